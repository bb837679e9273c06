// Text as other programs and editors leave it: marks at its beginning, ends of lines, separators,
// times in other units, and names of lenses. It is read, or refused in words that name the cause.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "datasets/readers/reader.h"
#include "datasets/sequence/plausible.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

using testing::HasSubstr;

// The small sequence with each file's text changed.
template <typename Change>
void write_changed(const std::filesystem::path& folder, const Change& change) {
  for (const auto& [name, text] : test::kGood) test::write_text(folder / name, change(name, text));
}

// Its numbers; frame 2 has no truth.
std::vector<double> numbers_in(const std::filesystem::path& folder) {
  Sequence sequence = read_sequence(folder);
  sequence.frames.pop_back();
  return test::numbers_of(sequence);
}

std::vector<double> good_numbers() {
  const test::TemporaryFolder folder;
  test::write_good(folder.path());
  return numbers_in(folder.path());
}

TEST(LineForms, AByteOrderMarkIsNoPartOfAnyFile) {
  const test::TemporaryFolder folder;
  write_changed(folder.path(), [](const auto&, const auto& text) { return "\xef\xbb\xbf" + text; });
  EXPECT_EQ(numbers_in(folder.path()), good_numbers());
}

TEST(LineForms, LinesEndInLfCrlfOrCr) {
  for (const char* end : {"\r\n", "\r"}) {
    const test::TemporaryFolder folder;
    write_changed(folder.path(), [&](const std::string&, const std::string& text) {
      return std::regex_replace(text, std::regex("\n"), end);
    });
    EXPECT_EQ(numbers_in(folder.path()), good_numbers()) << (end[1] == 0 ? "CR" : "CRLF");
  }
}

std::string refusal_with(const std::string& file, const std::string& text) {
  const test::TemporaryFolder folder;
  test::write_good(folder.path());
  test::write_text(folder.path() / file, text);
  return test::refusal_of([&] { read_sequence(folder.path()); });
}

TEST(LineForms, ALineAfterCrIsCounted) {
  EXPECT_THAT(refusal_with("frames.csv", "frame,timestamp\r0,0\r1,x\r"),
              HasSubstr("frames.csv:3: 'x' is not a number"));
}

TEST(LineForms, OtherSeparatorsAreNamed) {
  EXPECT_THAT(refusal_with("groundtruth.tum", "0,0,0,0,0,0,0,1\n"),
              HasSubstr("blanks are expected between fields where there are commas"));
  EXPECT_THAT(refusal_with("groundtruth.tum", "0, 0, 0, 0, 0, 0, 0, 1\n"),
              HasSubstr("blanks are expected between fields where there are commas"));
  EXPECT_THAT(refusal_with("groundtruth.tum", "0;0;0;0;0;0;0;1\n"),
              HasSubstr("blanks are expected between fields where there are semicolons"));
  EXPECT_THAT(refusal_with("frames.csv", "frame,timestamp\n0 0\n"),
              HasSubstr("commas are expected between fields where there are blanks"));
  EXPECT_THAT(refusal_with("frames.csv", "frame,timestamp\n0;0\n"),
              HasSubstr("commas are expected between fields where there are semicolons"));
}

TEST(LineForms, TheUnitOfATimeIsAsked) {
  for (const auto& [time, unit] : {std::pair("1403636579763.5", "milliseconds"),
                                   {"1403636579763555", "microseconds"},
                                   {"1403636579763555527", "nanoseconds"}}) {
    EXPECT_THAT(refusal_with("frames.csv", std::string("frame,timestamp\n0,") + time + "\n"),
                HasSubstr(std::string("are these ") + unit));
    EXPECT_THAT(refusal_with("groundtruth.tum", std::string(time) + " 0 0 0 0 0 0 1\n"),
                HasSubstr(std::string("are these ") + unit));
  }
  EXPECT_FALSE(time_fault(1403636579.76));
}

TEST(LineForms, AnUnknownLensIsToldWhatIsKnown) {
  std::string settings = test::kGood.at("sequence.yaml");
  settings.replace(settings.find("radtan"), 6, "fish_bowl");
  EXPECT_THAT(refusal_with("sequence.yaml", settings), HasSubstr("radtan (also plumb_bob"));
}

}  // namespace
}  // namespace slammot
