// Comparing: one folder a run, one JSON, one table; the sequence has no observations at all.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "eval/compare/compare.h"
#include "eval/compare/comparison_json.h"
#include "eval/output/judged_frames.h"
#include "eval/output/metrics_table.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

TEST(Compare, AFolderForEachRunAndOneJson) {
  const test::TemporaryFolder folder;
  CompareOptions options;
  options.output = folder.path();
  options.command = "slammot compare";
  options.seed = 5;
  const auto results = compare(test::straight_line(5), Configuration{},
                               crossed({"ekf", "static_world"}, {"scaled_velocity"}), options);
  ASSERT_EQ(results.size(), 2u);
  EXPECT_FALSE(results[0].metrics.diverged);
  EXPECT_EQ(results[1].landmark, "scaled_velocity");
  const auto json = nlohmann::json::parse(test::read_text(folder.path() / "compare.json"));
  EXPECT_EQ(json["format"], "slammot-compare-1");
  EXPECT_EQ(json["sequence"]["seed"], 5);
  EXPECT_EQ(json["truth"]["position"].size(), 5u);
  EXPECT_EQ(json["truth"]["landmarks"].size(), 2u);
  ASSERT_EQ(json["runs"].size(), 2u);
  const auto& run = json["runs"][1];
  EXPECT_EQ(run["label"], "static_world-scaled_velocity");
  EXPECT_EQ(run["configuration"]["classifier"], "all_static");
  EXPECT_FALSE(run["metrics"]["filtered"]["nees"].contains("series"));
  for (const char* name : {"timestamp", "position", "position_error_m", "rotation_error_deg",
                           "nees_pose", "frame", "nis_mean", "state_size", "frame_ms"}) {
    EXPECT_EQ(run["series"][name].size(), 5u) << name;
  }
  EXPECT_TRUE(run["series"]["nees_pose"][0].is_null());  // before the first prediction
  EXPECT_TRUE(run["smoothed_series"].is_null());
  for (const auto& result : results) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / result.label / "metrics.json"));
  }
  const std::string table = metrics_table(results);
  EXPECT_NE(table.find("static_world"), std::string::npos);
  EXPECT_NE(table.find("position RMSE m"), std::string::npos);
}

// The window in front of a batch may be lost where the batch is not.
TEST(Compare, ABatchIsJudgedByWhatItSmooths) {
  const Sequence sequence = test::straight_line(40);
  RunResult run;
  run.batch = true;
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    CameraEstimate camera;
    camera.timestamp = sequence.frames[i].timestamp;
    camera.state = *sequence.truth[i];
    camera.covariance.setIdentity();
    run.smoothed.push_back(camera);
    camera.state.position.y() += 100.0;
    run.filtered.push_back(camera);
    run.lagged[1].push_back(camera);
    run.frames.push_back(static_cast<int>(i));
    run.timing.push_back({static_cast<int>(i), "total", 2.0, 12});
  }
  run.smoothing_ms = 400.0;
  const RunMetrics metrics = compute_metrics(sequence, run, 0.95);
  EXPECT_FALSE(metrics.failed);
  EXPECT_TRUE(metrics.lagged.empty());  // of the window in front
  EXPECT_NEAR(metrics.runtime.frame_median_ms, 2.0 + 400.0 / 40, 1e-12);
  EXPECT_NEAR(metrics.runtime.frames_per_second, 1e3 * 40 / (40 * 2.0 + 400.0), 1e-9);
  ASSERT_EQ(metrics.runtime.stages.size(), 2u);
  EXPECT_EQ(metrics.runtime.stages[0].stage, "solution");
  const auto json =
      run_json(sequence, {"batch", "batch", "batch", false, "-", {}, {}}, run, metrics);
  EXPECT_NEAR(json["series"]["position_error_m"][5].get<double>(), 0.0, 1e-12);
  EXPECT_TRUE(json["smoothed_series"].is_null());
  EXPECT_EQ(json["frames"]["timestamp"].size(), 39u);  // without the first, a pin
  EXPECT_NEAR(json["frames"]["nees_pose"][5].get<double>(), 0.0, 1e-12);
  run.smoothed.clear();
  const RunMetrics unsolved = compute_metrics(sequence, run, 0.95);
  EXPECT_EQ(unsolved.judged().accuracy.reason, "no pose was estimated");
  run.batch = false;
  EXPECT_TRUE(compute_metrics(sequence, run, 0.95).failed);
  EXPECT_FALSE(compute_metrics(sequence, run, 0.95).lagged.empty());
}

TEST(JudgedFrames, CovariancesThatNobodyStatedHaveNoNees) {
  Sequence sequence;
  sequence.exact_truth = true;
  std::vector<PosePair> pairs(3);
  for (PosePair& pair : pairs) pair.estimate.covariance.setConstant(NAN);
  pairs[1].estimate.covariance.topLeftCorner<3, 3>().setIdentity();
  const auto frames = judged_frames(sequence, pairs);
  EXPECT_TRUE(frames.contains("nees_position"));  // stated of one pose
  EXPECT_FALSE(frames.contains("nees_pose"));
  EXPECT_FALSE(frames.contains("nees_rotation"));
}

}  // namespace
}  // namespace slammot
