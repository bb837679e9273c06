// Every input that once did harm, and single mutations of good files, through every reader: taken
// or refused in one line, never NaN, never slow.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/fuzz/target.h"
#include "tests/paths.h"

namespace slammot::fuzz {
namespace {

namespace fs = std::filesystem;

std::vector<const Target*> targets() {
  std::vector<const Target*> all;
  for (const auto table : {dataset_targets(), result_targets()}) {
    for (const Target& target : table) all.push_back(&target);
  }
  return all;
}

class Readers : public testing::TestWithParam<const Target*> {
 protected:
  static constexpr double kLongest = 2.0;  // [s]

  // The reason of a refusal, empty if taken; a fault of the reader fails the test.
  std::string run(const std::string& input) {
    const auto start = std::chrono::steady_clock::now();
    std::string reason;
    EXPECT_NO_THROW(reason = bench_.run(input)) << testing::PrintToString(input);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    EXPECT_LT(seconds.count(), kLongest) << testing::PrintToString(input);
    return reason;
  }

  const Bench bench_{*GetParam()};
};

TEST_P(Readers, TakeTheGoodFile) { EXPECT_EQ(run(bench_.good()), ""); }

TEST_P(Readers, WithstandTheCorpus) {
  const fs::path folder = fs::path(test::kSourceDir) / "tests/fuzz/corpus" / GetParam()->name;
  if (!fs::is_directory(folder)) return;
  for (const auto& entry : fs::directory_iterator(folder)) {
    std::ifstream in(entry.path(), std::ios::binary);
    run({std::istreambuf_iterator<char>(in), {}});
  }
}

// A byte changed, removed or repeated; a number replaced by one that is hard.
std::string mutated(std::string text, std::mt19937& engine) {
  constexpr const char* kHard[] = {
      "1e300", "-1e300", "1e-300", "nan",        "-inf",
      "0",     "-1",     "",       "2147483648", "99999999999999999999",
      "1e18",  "0x10",   "\xff",   "\x1b",       "\n",
      ",",     "a: *x",  "[[[[",   "{",          "null",
      "~",     "!!int 3"};
  const auto below = [&](size_t n) {
    return std::uniform_int_distribution<size_t>(0, n - 1)(engine);
  };
  const size_t at = below(text.size());
  switch (below(4)) {
    case 0:
      text[at] = static_cast<char>(below(256));
      break;
    case 1:
      text.erase(at, 1 + below(8));
      break;
    case 2:
      text.insert(at, text.substr(at, 1 + below(60)));
      break;
    default: {
      constexpr const char* kDigits = "0123456789.";
      const size_t begin = std::min(text.find_first_of(kDigits, at), text.size() - 1);
      const size_t end = text.find_first_not_of(kDigits, begin);
      text.replace(begin, end == std::string::npos ? 1 : end - begin,
                   kHard[below(std::size(kHard))]);
    }
  }
  return text;
}

// Where to look: a line, or what is wrong with a file as a whole; of metrics.json, which people do
// not write, the key or the value.
constexpr char kWhere[] =
    ":[0-9]+: |: no row '|: names no image|: no image within|: not a sequence|: [0-9]+ rows "
    "|'sweep' has more than|"
    "metrics.json: (key '.*' not found|not a count|type must be|not plausible)";

TEST_P(Readers, WithstandSingleMutations) {
  std::mt19937 engine(1);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::string reason = run(mutated(bench_.good(), engine));
    if (reason.empty()) continue;
    ++refused;
    EXPECT_THAT(reason, testing::ContainsRegex(kWhere));
  }
  RecordProperty("refused", refused);
  EXPECT_GT(refused, 0);
}

INSTANTIATE_TEST_SUITE_P(All, Readers, testing::ValuesIn(targets()),
                         [](const auto& tested) { return std::string(tested.param->name); });

}  // namespace

std::ostream& operator<<(std::ostream& out, const Target* target) { return out << target->name; }

}  // namespace slammot::fuzz
