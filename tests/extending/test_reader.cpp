// A reader, as docs/extending.md adds one: what stands between the `example` and `end` lines is
// named there, and that it compiles is half the test.
#include <gtest/gtest.h>

#include "datasets/readers/reader.h"
#include "datasets/sequence/sha256.h"
#include "datasets/text/text_table.h"
#include "tests/temporary_folder.h"

namespace slammot {
namespace {

// [example: reader]
// `pixels.txt`: rows `timestamp track u v` by time, then by track, from one camera.
bool is_pixel_list(const std::filesystem::path& folder) {
  return std::filesystem::is_regular_file(folder / "pixels.txt");
}

Sequence read_pixel_list(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "pixels.txt";
  const std::string text = read_text_file(file);
  Sequence sequence;
  sequence.name = folder.filename().string();
  sequence.folder = folder;
  sequence.camera = {640, 480, 385.0, 385.0, 319.5, 239.5, PinholeLens{}};
  TextTable table(file, text);
  while (table.next_blank_row(4)) {
    const double time = table.real(0);
    const Observation z{table.count(1), {table.real(2), table.real(3)}};
    std::vector<Frame>& frames = sequence.frames;
    if (frames.empty() || time > frames.back().timestamp) {
      frames.push_back({static_cast<int>(frames.size()), time, {}});
    } else if (time < frames.back().timestamp ||
               z.track <= frames.back().observations.back().track) {
      table.refuse("rows must be ordered by time, then by track");
    }
    frames.back().observations.push_back(z);
  }
  if (sequence.frames.empty()) throw InputError(file, 0, "no measurements");
  sequence.truth.resize(sequence.frames.size());
  Sha256 hash;
  hash.add(text);
  sequence.sha256 = hash.hex();
  return sequence;
}

constexpr ReaderRow kPixelList{"pixel_list", "pixels.txt", is_pixel_list, read_pixel_list};
// [end]

TEST(ExtendingReader, ReadsAndRefusesWithTheLine) {
  const test::TemporaryFolder folder;
  EXPECT_FALSE(kPixelList.recognises(folder.path()));
  test::write_text(folder.path() / "pixels.txt", "0.0 3 100 200\n0.0 5 120 90\n0.1 3 101 201\n");
  ASSERT_TRUE(kPixelList.recognises(folder.path()));
  const Sequence sequence = kPixelList.read(folder.path());
  ASSERT_EQ(sequence.frames.size(), 2u);
  EXPECT_EQ(sequence.frames[0].observations.size(), 2u);
  EXPECT_EQ(sequence.frames[1].observations[0].track, 3);
  test::write_text(folder.path() / "pixels.txt", "0.1 3 100 200\n0.0 5 120 90\n");
  try {
    kPixelList.read(folder.path());
    FAIL() << "time went back";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("pixels.txt:2:"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace slammot
