// Studies: their files, and what a run of one leaves.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "datasets/native/native_writer.h"
#include "datasets/simulation/scenario.h"
#include "datasets/text/input_error.h"
#include "eval/study/study_driver.h"
#include "eval/study/study_run.h"
#include "frontend/rendering/rendered_scenario.h"
#include "tests/paths.h"
#include "tests/temporary_folder.h"

namespace slammot {
namespace {

// The program's own rendered scenarios take long: another stands in for each.
void add_rendered() {
  constexpr auto helix = [](std::string_view name, const ScenarioOverrides& overrides,
                            std::uint64_t seed) {
    const std::vector<ScenarioParameter> known = scenario_parameters(name);
    for (const auto& [key, value] : overrides) {
      EXPECT_NE(std::ranges::find(known, key, &ScenarioParameter::name), known.end()) << key;
    }
    return simulate("helix", {}, seed);
  };
  static std::vector<ScenarioRow> rows(rendered_scenarios().begin(), rendered_scenarios().end());
  for (ScenarioRow& row : rows) row.simulate = helix;
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
}

TEST(Study, SaysWithinARunHowFarItIs) {
  const test::TemporaryFolder folder;
  test::write_text(folder.path() / "s.yaml", R"(format: slammot-study-1
name: s
runs: 3
scenarios: [{scenario: circle, set: {frames: 8}}]
estimators: [{estimator: ekf}]
)");
  const Study study = read_study(folder.path() / "s.yaml");
  StudyOptions options;
  options.output = folder.path() / "out";
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

TEST(Study, RefusesAScenarioAtItsLine) {
  const test::TemporaryFolder folder;
  for (const auto* scene : {"cirle", "circle, set: {movng: 3}", "circle, set: {moving: -3}"}) {
    test::write_text(folder.path() / "s.yaml", fmt::format(R"(format: slammot-study-1
name: s
runs: 1
scenarios:
  - {{scenario: circle, label: good}}
  - {{scenario: {}}}
estimators: [{{estimator: ekf}}]
)",
                                                           scene));
    EXPECT_THAT([&] { read_study(folder.path() / "s.yaml"); },
                testing::ThrowsMessage<InputError>(testing::HasSubstr("s.yaml:6: ")))
        << scene;
  }
}

TEST(Study, ARecordingThatChangesMeanwhileIsNotMixed) {
  const test::TemporaryFolder folder;
  write_native(simulate("circle", {{"frames", "8"}}, 1), folder.path() / "recorded");
  test::write_text(folder.path() / "s.yaml", R"(format: slammot-study-1
name: s
runs: 1
scenarios: [{sequence: recorded}]
estimators: [{estimator: ekf}]
)");
  const Study study = read_study(folder.path() / "s.yaml");
  EXPECT_TRUE(run_study_cell(study, 0, 0, {}).result.at("diverged").is_null());
  test::write_text(folder.path() / "recorded" / "known.csv", "track,x,y,z,sigma\n");
  EXPECT_THROW(run_study_cell(study, 0, 0, {}), InputError);
  std::filesystem::remove_all(folder.path() / "recorded");
  EXPECT_THROW(run_study_cell(study, 0, 0, {}), InputError);
}

}  // namespace
}  // namespace slammot
