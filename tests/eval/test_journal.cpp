// The journal of a study: whose runs are taken, who may write, and what a failure leaves.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "datasets/text/input_error.h"
#include "eval/journal/journal.h"
#include "tests/temporary_folder.h"

namespace slammot {
namespace {

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

TEST_F(JournalTest, GivesBackWhatWasAppended) {
  append(0, 1);
  append(1, 7);
  const Places found = places();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(read_run_line(found.at({1, 7}))["result"]["seed"], 7);
}

TEST_F(JournalTest, RefusesAnotherConfiguration) {
  append(0, 1);
  const JournalIdentity other{"1", "program", "other"};
  append(1, 1, other);
  EXPECT_NE(refusal().find("jsonl:3: these runs are of another configuration"), std::string::npos);
  EXPECT_NE(refusal({kMine, 2, true}).find("another configuration"), std::string::npos);
}

TEST_F(JournalTest, RefusesAnotherProgramUnlessMixed) {
  append(0, 1);
  append(1, 1, {"1", "rebuilt", "configuration"});
  EXPECT_NE(refusal().find("another build"), std::string::npos);
  EXPECT_EQ(places({kMine, 2, true}).size(), 2u);
}

TEST_F(JournalTest, RefusesRunsOfARecordingThatHasChangedUnlessMixed) {
  append(0, 1);
  append(1, 1, {"1", "program", "configuration", "recording"});
  EXPECT_NE(refusal().find("jsonl:3: a recorded sequence has changed"), std::string::npos);
  EXPECT_EQ(places({kMine, 2, true}).size(), 2u);
}

TEST_F(JournalTest, NamesFileAndLineOfWhatIsNoRun) {
  const std::string head = R"({"journal": {"version": "1", "program": "program", )"
                           R"("configuration": "configuration"}})";
  for (const char* line :
       {"", "[]", "7", "{", R"({"result": {"cell": 0, "seed": 1}})",
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
    EXPECT_NE(refusal().find("journal-1-of-1.jsonl:2: "), std::string::npos) << line;
  }
  test::write_text(
      file(),
      R"({"result": {"cell": 0, "seed": 1, "diverged": null}, "timing": {"cell": 0, "seed": 1}})"
      "\n");
  EXPECT_NE(refusal().find("do not say what program"), std::string::npos);
  EXPECT_EQ(places({kMine, 2, true}).size(), 1u);
}

TEST_F(JournalTest, IsLockedWhileSomebodyWrites) {
  const Journal first(path(), "journal-1-of-2.jsonl", kMine);
  EXPECT_THROW(Journal(path(), "journal-1-of-2.jsonl", kMine), std::invalid_argument);
  EXPECT_THROW(Journal(path(), "journal-1-of-3.jsonl", kMine), std::invalid_argument);
  EXPECT_NO_THROW(Journal(path(), "journal-2-of-2.jsonl", kMine));
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
