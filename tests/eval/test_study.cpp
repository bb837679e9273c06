// Statistics of studies on runs whose answers are known.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "datasets/native/native_writer.h"
#include "datasets/simulation/scenario.h"
#include "datasets/text/input_error.h"
#include "eval/statistics/bootstrap.h"
#include "eval/statistics/statistics.h"
#include "eval/study/study_driver.h"
#include "eval/study/study_run.h"
#include "eval/study/summary/study_summary.h"
#include "frontend/rendering/rendered_scenario.h"
#include "tests/paths.h"
#include "tests/temporary_folder.h"

namespace slammot {
namespace {

using Json = nlohmann::ordered_json;

TEST(Bootstrap, IntervalOfAMeanIsThatOfTheNormalDistribution) {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal(3.0, 2.0);
  std::vector<double> samples(400);
  for (double& x : samples) x = normal(engine);
  const Estimate e = bootstrap(samples, mean);
  const double half = 1.96 * 2.0 / std::sqrt(400.0);
  EXPECT_NEAR(e.value, 3.0, 2.0 * half);
  EXPECT_NEAR(e.upper - e.value, half, 0.15 * half);
  EXPECT_NEAR(e.value - e.lower, half, 0.15 * half);
  EXPECT_EQ(bootstrap(samples, mean).lower, e.lower);  // the same every time
  EXPECT_TRUE(std::isnan(bootstrap({1.0}, mean).lower));
}

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

class Summary : public testing::Test {
 protected:
  static constexpr int kRuns = 50, kFrames = 100;

  void SetUp() override {
    folder_ =
        std::filesystem::temp_directory_path() / ("slammot-summary-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    for (const char* label : {"honest", "overconfident", "ideal_covariance"}) {
      StudyCell cell;
      cell.group = "g";
      cell.label = label;
      cell.estimator = cell.label == "ideal_covariance" ? cell.label : "ekf";
      study_.cells.push_back(cell);
    }
    study_.runs = kRuns;
    std::ofstream results(folder_ / "results.jsonl"), timing(folder_ / "timing.jsonl");
    for (int cell = 0; cell < 3; ++cell) {
      for (int run = 0; run < kRuns; ++run) {
        results << made_run(cell, run).dump() << '\n';
        timing << Json{{"cell", cell}, {"seed", run + 1}, {"seconds", 1.0}}.dump() << '\n';
      }
    }
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Errors of 0.1 m a component; what is stated is that (honest), a half (overconfident), or 0.08
  // (ideal_covariance). Run 7 of the overconfident one diverges.
  Json made_run(int cell, int run) {
    std::mt19937_64 engine(static_cast<unsigned>(run + 1));
    std::normal_distribution<double> normal;
    const double stated[] = {0.1, 0.05, 0.08};
    Json frames = {{"frame", Json::array()}};
    double squares = 0.0;
    for (int f = 1; f <= kFrames; ++f) {
      double position = 0.0, rotation = 0.0;
      for (int i = 0; i < 3; ++i) position += std::pow(0.1 * normal(engine), 2);
      for (int i = 0; i < 3; ++i) rotation += std::pow(0.1 * normal(engine), 2);
      squares += position / kFrames;
      const double s = stated[cell];
      frames["frame"].push_back(f);
      frames["position_error_m"].push_back(std::sqrt(position));
      frames["rotation_error_deg"].push_back(std::sqrt(rotation));
      frames["nees_pose"].push_back((position + rotation) / (s * s));
      frames["nees_position"].push_back(position / (s * s));
      frames["nees_rotation"].push_back(rotation / (s * s));
      frames["position_sigma_m"].push_back(std::sqrt(3.0) * s);
      add_landmarks(engine, frames);
    }
    Json json = {{"cell", cell}, {"seed", run + 1}, {"diverged", nullptr}, {"lost_at", nullptr}};
    if (cell == 1 && run == 6) json["diverged"] = {{"frame", 100}, {"reason", "not a number"}};
    // The second estimator is worse by a centimetre in every run.
    const double rmse = std::sqrt(squares) + (cell == 1 ? 0.01 : 0.0);
    json["filtered"] = {{"position_rmse_m", rmse}, {"rotation_rmse_deg", 1.0}};
    json["smoothed"] = nullptr;
    json["nis_mean"] = json["nis_expected"] = json["median_frames_to_decision"] = 1.0;
    json["static"] = {8, 1, 1};
    json["moving"] = {5, 0, 2};
    json["static_often_seen"] = {8, 0, 0};
    json["moving_often_seen"] = {5, 0, 0};
    json["standing_by_frame"] = {0, 0, 0};
    json["moving_by_frame"] = {50, 10, 20};
    json["coverage"] = {{"offered", 10}};
    json["frames"] = frames;
    json["landmarks"] = {{{"observations", 5},
                          {"static_position_m", {0.1, 0.2, 0.3}},
                          {"moving_position_m", Json::array()},
                          {"moving_velocity_m_s", Json::array()},
                          {"nees_position_mean", 2.0 + run % 2},
                          {"nees_position_count", 4},
                          {"nees_velocity_mean", nullptr},
                          {"nees_velocity_count", 0}}};
    json["tracks"] = Json::array();
    return json;
  }

  // Twenty landmarks whose errors have half their variance in common: their mean NEES is 3, and
  // scatters from run to run far more than that of sixty independent numbers. None has a velocity.
  static void add_landmarks(std::mt19937_64& engine, Json& frames) {
    constexpr int kLandmarks = 20;
    std::normal_distribution<double> normal;
    double nees = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double common = normal(engine);
      for (int i = 0; i < kLandmarks; ++i) {
        nees += std::pow(std::sqrt(0.5) * (common + normal(engine)), 2) / kLandmarks;
      }
    }
    frames["nees_landmark_position"].push_back(nees);
    frames["landmark_position_count"].push_back(kLandmarks);
    frames["nees_landmark_velocity"].push_back(nullptr);
    frames["landmark_velocity_count"].push_back(0);
  }

  Study study_;
  std::filesystem::path folder_;
};

TEST_F(Summary, SaysWhatTheRunsSay) {
  const Json group = summarise_study(study_, folder_)["groups"].at(0);
  const Json &honest = group["cells"][0], &overconfident = group["cells"][1];
  EXPECT_NEAR(honest["anees"]["pose"]["mean"].get<double>(), 6.0, 0.15);
  EXPECT_NEAR(honest["anees"]["position"]["mean"].get<double>(), 3.0, 0.1);
  EXPECT_GE(honest["anees"]["pose"]["inside"].get<double>(), 0.88);
  EXPECT_NEAR(overconfident["anees"]["pose"]["mean"].get<double>(), 24.0, 0.6);
  EXPECT_EQ(overconfident["anees"]["pose"]["inside"].get<double>(), 0.0);
  EXPECT_EQ(honest["static"], Json({400, 50, 50}));
  EXPECT_NEAR(honest["filtered_position_rmse_m"]["value"].get<double>(), std::sqrt(0.03), 0.003);
  EXPECT_NEAR(honest["rmse_over_ideal"]["position"].get<double>(), 0.1 / 0.08, 0.02);
  double nees = 0.0;
  for (const Json& run : honest["rmse_over_ideal"]["runs"]) nees += run["nees_pose"].get<double>();
  EXPECT_NEAR(nees / static_cast<double>(honest["rmse_over_ideal"]["runs"].size()),
              honest["anees"]["pose"]["mean"].get<double>(), 1e-6);
  const Json& age = honest["by_age"][0];
  EXPECT_EQ(age["static_position_m"]["median"].get<double>(), 0.2);
  EXPECT_EQ(age["nees_position"]["mean"].get<double>(), 2.5);
  EXPECT_TRUE(age["nees_velocity"].is_null());
}

TEST_F(Summary, AnIntervalOfLandmarksCountsRunsNotLandmarks) {
  const Json cell = summarise_study(study_, folder_)["groups"].at(0)["cells"][0];
  const Json& anees = cell["anees"]["landmark_position"];
  EXPECT_NEAR(anees["mean"].get<double>(), 3.0, 0.1);
  EXPECT_GE(anees["inside"].get<double>(), 0.85);  // were all landmarks independent: about a half
  EXPECT_LE(anees["inside"].get<double>(), 0.99);
  EXPECT_FALSE(std::isfinite(cell["anees"]["landmark_velocity"]["mean"].get<double>()));
  EXPECT_EQ(cell["per_frame"]["anees_landmark_position_lower"].size(), std::size_t{kFrames});
}

TEST_F(Summary, EachPartHasTheIntervalOfItsDegreesOfFreedom) {
  const Json f = summarise_study(study_, folder_)["groups"].at(0)["cells"][0]["per_frame"];
  EXPECT_NEAR(f["anees_pose_upper"][0].get<double>(), 7.0, 0.1);       // chi2inv(.975, 300) / 50
  EXPECT_NEAR(f["anees_position_upper"][0].get<double>(), 3.72, 0.1);  // chi2inv(.975, 150) / 50
  EXPECT_EQ(f["anees_rotation_upper"][0], f["anees_position_upper"][0]);
}

TEST_F(Summary, ADivergedRunIsNamedAndLoses) {
  const Json group = summarise_study(study_, folder_)["groups"].at(0);
  EXPECT_TRUE(group["cells"][0]["diverged"].empty());
  ASSERT_EQ(group["cells"][1]["diverged"].size(), 1u);
  EXPECT_EQ(group["cells"][1]["diverged"][0]["seed"], 7);
  EXPECT_EQ(group["cells"][1]["filtered_position_rmse_m"]["runs"], kRuns - 1);
  ASSERT_EQ(group["pairs"].size(), 1u);  // the ideal covariance takes part in none
  const Json& pair = group["pairs"][0];
  EXPECT_EQ(pair["wins_a"], kRuns);
  EXPECT_EQ(pair["wins_b"], 0);
  EXPECT_NEAR(pair["position_rmse_difference_m"]["value"].get<double>(), -0.01, 1e-9);
  EXPECT_EQ(pair["position_rmse_difference_m"]["runs"], kRuns - 1);
}

}  // namespace
}  // namespace slammot
