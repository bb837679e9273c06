// What is judged of a run: metrics of every lag, consistency, counts of labels.
#include <gtest/gtest.h>

#include <cmath>

#include "eval/metrics/metrics.h"
#include "eval/output/metrics_json.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

using test::driven;
using test::landmark;

// The last ones have no pose at the longest lag: with them a growing error would fall with the lag.
TEST(Metrics, OfEveryLagAreOverTheSameFrames) {
  const Sequence sequence = test::straight_line(50);
  RunResult run = driven(sequence);
  EXPECT_TRUE(compute_metrics(sequence, run, 0.95).lagged.empty());
  for (const int lag : {1, 4}) run.lagged[lag] = {run.filtered.begin(), run.filtered.end() - lag};
  const auto metrics = compute_metrics(sequence, run, 0.95).lagged;
  ASSERT_EQ(metrics.size(), 3u);
  for (const auto& [lag, judged] : metrics) {
    EXPECT_EQ(judged.accuracy.value->poses, metrics.at(0).accuracy.value->poses) << lag;
  }
  EXPECT_LE(metrics.at(0).accuracy.value->poses, 11);
}

// Half the error, with the covariance as it was.
TEST(Metrics, RatiosOfALagAreOverTheSameRunAsFiltered) {
  const Sequence sequence = test::straight_line(50);
  RunResult run =
      driven(sequence, [](int, auto& belief) { belief.camera.state.position.y() = 0.5; });
  const auto value = [&](const char* key) {
    return value_of(compute_metrics(sequence, run, 0.95).values, key);
  };
  EXPECT_TRUE(std::isnan(value("lag.4.position_rmse_ratio")));
  run.lagged[4] = {run.filtered.begin(), run.filtered.end() - 4};
  for (CameraEstimate& camera : run.lagged[4]) camera.state.position.y() = 0.25;
  EXPECT_DOUBLE_EQ(value("lag.4.position_rmse_ratio"), 0.5);
  EXPECT_DOUBLE_EQ(value("lag.4.nees_pose_ratio"), 0.25);
  EXPECT_TRUE(std::isnan(value("lag.4.rotation_rmse_ratio")));  // of none
}

TEST(ClassificationTable, CountsAndRatios) {
  using enum Label;
  std::vector<ClassificationRecord> records;
  for (const auto& [truth, label] :
       {std::pair{kStatic, kStatic}, std::pair{kStatic, kStatic}, std::pair{kStatic, kMoving},
        std::pair{kStatic, kUnknown}, std::pair{kMoving, kMoving}, std::pair{kMoving, kStatic}}) {
    records.push_back({0, truth, label, std::nullopt, 1});
  }
  records.push_back({7, std::nullopt, kMoving, 3, 2});
  const ClassificationMetrics m = classification_metrics(records);
  EXPECT_EQ(m.statics.right, 2);
  EXPECT_EQ(m.statics.wrong, 1);
  EXPECT_EQ(m.statics.undecided, 1);
  EXPECT_DOUBLE_EQ(m.statics.wrongly_classified(), 0.25);
  EXPECT_DOUBLE_EQ(m.statics.misclassified(), 0.5);
  EXPECT_DOUBLE_EQ(m.movings.misclassified(), 0.5);
  EXPECT_EQ(m.without_truth, 1);
  EXPECT_TRUE(std::isnan(ClassCounts{}.misclassified()));
}

TEST(Metrics, NeesNeedsExactTruthAndJsonHasNoNan) {
  Sequence sequence = test::straight_line(4);
  const RunResult run = driven(sequence, [](int i, auto& belief) {
    belief.landmarks = {landmark(0, Label::kStatic, 1, i, 1, 1),
                        landmark(1, Label::kMoving, 1, i, 1, 1)};
    belief.landmarks[1].position = Eigen::Vector3d(0, 0, 5.5 + i);
    belief.landmarks[1].position_covariance.setIdentity();
  });
  const RunMetrics exact = compute_metrics(sequence, run, 0.95);
  ASSERT_TRUE(exact.filtered.consistency.value);
  EXPECT_EQ(exact.filtered.consistency.value->pose.used, 3);
  ASSERT_TRUE(exact.landmark_consistency.value);
  EXPECT_EQ(exact.landmark_consistency.value->position.used, 1);  // that of track 0 is undefined
  EXPECT_NEAR(exact.landmark_consistency.value->position.mean, 0.25, 1e-12);
  EXPECT_EQ(exact.landmark_consistency.value->velocity.used, 0);
  EXPECT_EQ(metrics_json(exact).dump().find("nan"), std::string::npos);

  sequence.exact_truth = false;
  const auto json = metrics_json(compute_metrics(sequence, run, 0.95));
  EXPECT_TRUE(json["filtered"]["nees"].is_null());
  EXPECT_EQ(json["filtered"]["nees_reason"], "truth is not exact");
  EXPECT_TRUE(json["filtered"]["accuracy"].is_object());
}

TEST(Metrics, NisOfTheAccepted) {
  const Sequence sequence = test::straight_line(2);
  const RunResult run = driven(sequence, [](int, auto& belief) {
    belief.report.accepted = 10;
    belief.report.rejected = 2;
    belief.report.nis_sum = 17.0;
  });
  const RunMetrics metrics = compute_metrics(sequence, run, 0.95);
  EXPECT_DOUBLE_EQ(metrics.nis.mean, 1.7);
  EXPECT_NEAR(metrics.nis.expected, 1.685, 5e-4);
  EXPECT_EQ(metrics.measurements.offered, 24);
}

}  // namespace
}  // namespace slammot
