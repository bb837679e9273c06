// Studies: their files, and what a run of one leaves.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "datasets/native/native_writer.h"
#include "datasets/simulation/scenario.h"
#include "datasets/text/input_error.h"
#include "datasets/text/text_table.h"
#include "eval/study/study_driver.h"
#include "eval/study/study_run.h"
#include "frontend/rendering/rendered_scenario.h"
#include "tests/paths.h"
#include "tests/temporary_folder.h"

namespace slammot {
namespace {

// The program's own rendered scenarios, which no study renders to be read.
void add_rendered() {
  static std::vector<ScenarioRow> rows(rendered_scenarios().begin(), rendered_scenarios().end());
  for (ScenarioRow& row : rows) {
    row.simulate = [](std::string_view name, const ScenarioOverrides&, std::uint64_t) {
      ADD_FAILURE() << name;
      return Sequence{};
    };
  }
  add_scenarios(rows);
}

TEST(Study, EachThatShipsCanBeRead) {
  add_rendered();
  int count = 0;
  const std::filesystem::path folder = std::filesystem::path(test::kSourceDir) / "eval/studies";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    try {
      EXPECT_GT(read_study(entry.path()).cells.size(), 1U) << entry.path();
      ++count;
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
    }
  }
  EXPECT_GT(count, 10);
  EXPECT_NO_THROW(check_scenario("basement", {{"stereo", "0.12"}}, 1));
  EXPECT_THROW(check_scenario("basement", {{"sterio", "0.12"}}, 1), std::invalid_argument);
}

// In a folder of its own.
class StudyFile : public testing::Test {
 protected:
  Study read(const std::string& scenarios, int runs) const {
    test::write_text(path() / "s.yaml", fmt::format(R"(format: slammot-study-1
name: s
runs: {}
scenarios:
  - {}
estimators: [{{estimator: ekf}}]
)",
                                                    runs, scenarios));
    return read_study(path() / "s.yaml");
  }
  std::filesystem::path path() const { return folder_.path(); }

  const test::TemporaryFolder folder_;
};

TEST_F(StudyFile, SaysWithinARunHowFarItIs) {
  const Study study = read("{scenario: circle, set: {frames: 8}}", 3);
  StudyOptions options;
  options.output = path() / "out";
  options.jobs = 2;
  int calls = 0, within = 0, runs_done = 0;
  double done = 0.0;
  options.progress = [&](const StudyProgress& p) {
    ++calls;
    within += p.frames_done > 0 && p.frames_done < p.frames ? 1 : 0;
    EXPECT_EQ(p.runs, 3);
    EXPECT_LE(p.frames, 16);
    EXPECT_GE(p.runs_done + p.parts_done, done - 1e-9);
    done = p.runs_done + p.parts_done;
    runs_done = p.runs_done;
  };
  claim_folder(study, options.output, options.shard, false);
  run_study(study, options);
  EXPECT_EQ(calls, 3 * (8 + 1));
  EXPECT_GE(within, 3 * 7 - 2);
  EXPECT_EQ(runs_done, 3);
  EXPECT_NEAR(done, 3.0, 1e-9);
}

// The EKF reads no key of the window, nor the window one of the EKF's.
TEST_F(StudyFile, CellsThatAreTheSameAreComputedOnce) {
  test::write_text(path() / "s.yaml", R"(format: slammot-study-1
name: s
runs: 2
scenarios: [{scenario: circle, set: {frames: 8}}]
sweep: {window.frames: [2, 3], ekf.iterations: [1, 2]}
estimators: [{estimator: ekf}, {estimator: window}, {estimator: true_labels}, {estimator: ekf, label: again}]
)");
  const Study study = read_study(path() / "s.yaml");
  std::vector<int> computed_by;
  for (const StudyCell& cell : study.cells) computed_by.push_back(cell.computed_by);
  EXPECT_THAT(computed_by, testing::ElementsAre(0, 1, 2, 0, 4, 1, 6, 4, 0, 9, 2, 0, 4, 9, 6, 4));
  StudyOptions options;
  options.output = path() / "out";
  claim_folder(study, options.output, options.shard, false);
  EXPECT_EQ(run_study(study, options).ran, 2 * 6);
  merge_runs(study, {options.output}, options.output, false);
  std::istringstream lines(read_text_file(options.output / "results.jsonl"));
  std::string line;
  for (int cell = 0; cell < std::ssize(study.cells); ++cell) {
    for (int run = 0; run < study.runs; ++run) {
      ASSERT_TRUE(std::getline(lines, line));
      EXPECT_EQ(line, run_study_cell(study, cell, run, {}).result.dump()) << cell;
    }
  }
  EXPECT_EQ(run_study(study, options).kept, 2 * 6);
  // Nor does the time of what was computed count twice.
  std::istringstream times(read_text_file(options.output / "timing.jsonl"));
  int timed = 0, all = 0;
  for (; std::getline(times, line); ++all) {
    timed += nlohmann::json::parse(line).at("seconds") > 0.0 ? 1 : 0;
  }
  EXPECT_EQ(all, 2 * 16);
  EXPECT_EQ(timed, 2 * 6);
}

TEST_F(StudyFile, IsRefusedAtTheLineOfAScenario) {
  for (const auto* scene : {"cirle", "circle, set: {movng: 3}", "circle, set: {moving: -3}"}) {
    EXPECT_THAT(
        [&] {
          read(fmt::format("{{scenario: circle, label: good}}\n  - {{scenario: {}}}", scene), 1);
        },
        testing::ThrowsMessage<InputError>(testing::HasSubstr("s.yaml:6: ")))
        << scene;
  }
}

TEST_F(StudyFile, ARecordingThatChangesMeanwhileIsNotMixed) {
  write_native(simulate("circle", {{"frames", "8"}}, 1), path() / "recorded");
  const Study study = read("{sequence: recorded}", 1);
  EXPECT_TRUE(run_study_cell(study, 0, 0, {}).result.at("diverged").is_null());
  test::write_text(path() / "recorded" / "known.csv", "track,x,y,z,sigma\n");
  EXPECT_THROW(run_study_cell(study, 0, 0, {}), InputError);
  std::filesystem::remove_all(path() / "recorded");
  EXPECT_THROW(run_study_cell(study, 0, 0, {}), InputError);
}

}  // namespace
}  // namespace slammot
