// The journal of a study: whose runs are taken, who may write, and what a failure leaves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "datasets/text/input_error.h"
#include "eval/journal/journal.h"
#include "tests/temporary_folder.h"

namespace slammot {
namespace {

using testing::HasSubstr;
using Json = nlohmann::ordered_json;
using Places = std::map<RunKey, RunPlace>;

const JournalIdentity kMine{"1", "program", "configuration"};

class JournalTest : public testing::Test {
 protected:
  std::filesystem::path path() const { return folder_.path(); }
  std::filesystem::path file() const { return path() / "journal-1-of-1.jsonl"; }

  void append(int cell, int seed, const JournalIdentity& identity = kMine,
              const char* name = "journal-1-of-1.jsonl") const {
    const Json timing = {{"cell", cell}, {"seed", seed}};
    Json result = timing;
    result["diverged"] = nullptr;
    Journal(path(), name, identity).append(result, timing);
  }
  Places places(const JournalRules& rules = {kMine, 2, false}) const {
    Places found;
    add_journals(path(), rules, found);
    return found;
  }
  std::string refusal(const JournalRules& rules = {kMine, 2, false}) const {
    try {
      places(rules);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  test::TemporaryFolder folder_;
};

TEST_F(JournalTest, RefusesRunsOfAnotherConfigurationAndOthersUnlessMixed) {
  const JournalRules mixed{kMine, 2, true};
  append(0, 1);
  const std::string before = test::read_text(file());
  const auto with = [&](const JournalIdentity& other) {
    test::write_text(file(), before);
    append(1, 1, other);
    return refusal();
  };
  EXPECT_THAT(with({"1", "program", "other"}),
              HasSubstr("jsonl:3: these runs are of another conf"));
  EXPECT_THAT(refusal(mixed), HasSubstr("another configuration"));
  EXPECT_THAT(with({"1", "rebuilt", "configuration"}), HasSubstr("another build"));
  EXPECT_EQ(places(mixed).size(), 2u);
  EXPECT_THAT(with({"1", "program", "configuration", "recording"}),
              HasSubstr("jsonl:3: a recorded sequence has changed"));
  EXPECT_EQ(places(mixed).size(), 2u);
}

TEST_F(JournalTest, NamesFileAndLineOfWhatIsNoRun) {
  const std::string head = R"({"journal": {"version": "1", "program": "program", )"
                           R"("configuration": "configuration"}})";
  const std::string run =
      R"({"result": {"cell": 0, "seed": 1, "diverged": null}, "timing": {"cell": 0, "seed": 1})";
  const std::string deep =
      run + R"(, "x": )" + std::string(99'999, '[') + std::string(99'999, ']') + "}";
  for (const char* line :
       {deep.c_str(), "", "[]", "7", "{", R"({"result": {"cell": 0, "seed": 1}})",
        R"({"result": {"cell": 0}, "timing": {"cell": 0}})",
        R"({"result": {"seed": 1}, "timing": {"seed": 1}})",
        R"({"result": {"cell": -1, "seed": 1}, "timing": {"cell": -1, "seed": 1}})",
        R"({"result": {"cell": 2, "seed": 1}, "timing": {"cell": 2, "seed": 1}})",
        R"({"result": {"cell": 4294967296, "seed": 1}, "timing": {"cell": 4294967296, "seed": 1}})",
        R"({"result": {"cell": 0, "seed": 1}, "timing": {"cell": 1, "seed": 1}})",
        R"({"result": {"cell": "0", "seed": 1}, "timing": {"cell": "0", "seed": 1}})",
        R"({"result": {"cell": 0, "seed": 1}, "timing": {"cell": 0, "seed": 1}})",
        R"({"result": {"cell": 0, "seed": 1, "diverged": 3}, "timing": {"cell": 0, "seed": 1}})",
        R"({"journal": {"version": "1"}})", R"({"journal": 1})", "{\"result\": \"\xff\"}"}) {
    test::write_text(file(), head + "\n" + line + "\n");
    EXPECT_THAT(refusal(), HasSubstr("journal-1-of-1.jsonl:2: ")) << std::string(line, 0, 99);
  }
  test::write_text(file(), run + "}\n");
  EXPECT_THAT(refusal(), HasSubstr("do not say what program"));
  EXPECT_EQ(places({kMine, 2, true}).size(), 1u);
}

TEST_F(JournalTest, CutsOffHalfALine) {
  append(0, 1);
  std::ofstream(file(), std::ios::app) << R"({"result": {"cell": 1, "se)";
  EXPECT_EQ(places().size(), 1u);
  append(1, 1);
  EXPECT_EQ(places().size(), 2u);
}

// As on a full device: the line that does not fit leaves nothing that the next would be joined to.
TEST_F(JournalTest, ALineThatDoesNotFitLeavesNothing) {
  append(0, 1);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit full = before;
  full.rlim_cur = std::filesystem::file_size(file()) + 10;
  {
    Journal journal(path(), "journal-1-of-1.jsonl", kMine);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &full), 0);
    const Json run = {{"cell", 1}, {"seed", 1}, {"diverged", nullptr}};
    EXPECT_THROW(journal.append(run, run), std::runtime_error);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    journal.append(run, run);
  }
  EXPECT_EQ(places().size(), 2u);
}

}  // namespace
}  // namespace slammot
