// Driving an estimator: what is collected, what divergence leaves, how labels are counted.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "eval/metrics/metrics.h"
#include "eval/output/metrics_json.h"
#include "eval/run/run.h"
#include "eval/run/stage_clock.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

using test::FakeEstimator;
using test::landmark;

TEST(Drive, CollectsFramesAndTimes) {
  const Sequence sequence = test::straight_line(4);
  FakeEstimator estimator([&](const Frame& f) { return test::true_belief(sequence, f); });
  int calls = 0;
  DriveOptions options;
  options.progress = [&](int done, int total) {
    EXPECT_EQ(done, ++calls);
    EXPECT_EQ(total, 4);
  };
  const RunResult run = drive(sequence, estimator, options);
  EXPECT_EQ(calls, 4);
  EXPECT_EQ(run.frames, (std::vector{0, 1, 2, 3}));
  ASSERT_EQ(run.timing.size(), 12u);  // predict, update and total of each frame
  EXPECT_EQ(run.timing[2].stage, "total");
  EXPECT_GE(run.timing[2].milliseconds, run.timing[0].milliseconds + run.timing[1].milliseconds);
  EXPECT_FALSE(run.diverged);
}

// What is noted for pictures is a stage of its own.
TEST(StageClock, TheWholeIsWithoutIt) {
  using Clock = std::chrono::steady_clock;
  using Milliseconds = std::chrono::duration<double, std::milli>;
  const Clock::time_point begun = Clock::now();
  StageClock clock;
  clock.begin("gate");
  clock.begin(StageListener::kPredictions);
  const Clock::time_point noted = Clock::now();
  while (Clock::now() - noted < Milliseconds(20.0)) continue;
  clock.begin("update");
  const auto stages = clock.finish();
  const double all = Milliseconds(Clock::now() - begun).count();
  ASSERT_EQ(stages.size(), 4u);
  EXPECT_EQ(stages[3].first, "total");
  EXPECT_GE(stages[1].second, 20.0);
  EXPECT_GE(stages[3].second, stages[0].second + stages[2].second - 1e-9);
  EXPECT_LE(stages[3].second, all - stages[1].second + 1e-9);
}

// The last ones have no pose at the longest lag: with them a growing error would fall with the lag.
TEST(Metrics, OfEveryLagAreOverTheSameFrames) {
  const Sequence sequence = test::straight_line(50);
  FakeEstimator estimator([&](const Frame& f) { return test::true_belief(sequence, f); });
  RunResult run = drive(sequence, estimator);
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
  FakeEstimator estimator([&](const Frame& f) {
    test::Belief belief = test::true_belief(sequence, f);
    belief.camera.state.position.y() = 0.5;
    return belief;
  });
  RunResult run = drive(sequence, estimator);
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

TEST(Drive, ADivergedRunKeepsWhatWasFinished) {
  const Sequence sequence = test::straight_line(5);
  FakeEstimator says_so([&](const Frame& f) {
    if (f.index == 3) throw Diverged("covariance is not positive");
    return test::true_belief(sequence, f);
  });
  const RunResult run = drive(sequence, says_so);
  ASSERT_TRUE(run.diverged);
  EXPECT_EQ(run.diverged->frame, 3);
  EXPECT_EQ(run.diverged->reason, "covariance is not positive");
  EXPECT_EQ(run.filtered.size(), 3u);
  EXPECT_EQ(run.frames_offered, 5);
  EXPECT_EQ(metrics_json(compute_metrics(sequence, run, 0.95))["diverged"], true);
}

TEST(Drive, WhatCannotBeIsDivergence) {
  const Sequence sequence = test::straight_line(5);
  using Spoil = void (*)(CameraEstimate&);
  for (const Spoil spoil : {Spoil([](CameraEstimate& c) { c.covariance(3, 4) = kUndefined; }),
                            Spoil([](CameraEstimate& c) { c.state.velocity.x() = kUndefined; }),
                            Spoil([](CameraEstimate& c) { c.state.position.x() = 1e150; })}) {
    FakeEstimator estimator([&](const Frame& f) {
      test::Belief belief = test::true_belief(sequence, f);
      if (f.index == 2) spoil(belief.camera);
      return belief;
    });
    const RunResult run = drive(sequence, estimator);
    ASSERT_TRUE(run.diverged);
    EXPECT_EQ(run.diverged->frame, 2);
    EXPECT_EQ(run.filtered.size(), 2u);
  }
}

TEST(Drive, ACameraThatIsLostHasNotDiverged) {
  const Sequence sequence = test::straight_line(5);
  FakeEstimator estimator([&](const Frame& f) {
    test::Belief belief = test::true_belief(sequence, f);
    belief.camera.state.position.x() = 1e6;
    return belief;
  });
  EXPECT_FALSE(drive(sequence, estimator).diverged);
}

// A landmark that leaves keeps its latest belief; one that comes back anew replaces it.
TEST(Drive, LandmarksAreRememberedAfterTheyLeave) {
  const Sequence sequence = test::straight_line(6);
  FakeEstimator estimator([&](const Frame& f) {
    test::Belief belief = test::true_belief(sequence, f);
    if (f.index <= 2) {
      belief.landmarks.push_back(landmark(0, f.index < 1 ? Label::kUnknown : Label::kStatic, 0,
                                          f.index, f.index < 1 ? std::nullopt : std::optional(1),
                                          f.index + 1));
      belief.landmarks.push_back(landmark(1, Label::kStatic, 0, f.index, 0, f.index + 1));
    }
    if (f.index == 3) belief.report.retired = {landmark(1, Label::kMoving, 0, 2, 3, 3)};
    if (f.index >= 4) {
      belief.landmarks.push_back(
          landmark(0, Label::kUnknown, 4, f.index, std::nullopt, f.index - 3));
    }
    return belief;
  });
  const RunResult run = drive(sequence, estimator);
  ASSERT_EQ(run.landmarks.size(), 2u);
  EXPECT_EQ(run.landmarks[0].frame, 5);
  EXPECT_EQ(run.landmarks[0].estimate.first_frame, 4);
  EXPECT_EQ(run.landmarks[1].frame, 2);  // its newest measurement, not the frame of its removal
  EXPECT_EQ(run.classification[1].label, Label::kMoving);  // the last word
  ASSERT_EQ(run.classification.size(), 2u);
  EXPECT_FALSE(run.classification[0].decision_frame);
  EXPECT_EQ(run.classification[0].observations, 2);
  EXPECT_EQ(run.totals.pruned, 1);
  EXPECT_EQ(run.samples.size(), 8u);  // 2 x 3 frames, then track 0 twice
}

TEST(Drive, ObservationsAreCountedUntilTheDecision) {
  const Sequence sequence = test::straight_line(6);
  FakeEstimator estimator([&](const Frame& f) {
    test::Belief belief = test::true_belief(sequence, f);
    const bool decided = f.index >= 2;
    belief.landmarks = {landmark(1, decided ? Label::kMoving : Label::kUnknown, 0, f.index,
                                 decided ? std::optional(2) : std::nullopt, f.index + 1)};
    return belief;
  });
  const RunResult run = drive(sequence, estimator);
  ASSERT_EQ(run.classification.size(), 1u);
  EXPECT_EQ(run.classification[0].observations, 3);
  EXPECT_EQ(compute_metrics(sequence, run, 0.95).classification.median_frames_to_decision, 3.0);
}

TEST(Drive, LandmarksByRuleAreNotClassified) {
  Sequence sequence = test::straight_line(2);
  sequence.known.push_back({1, Eigen::Vector3d(0, 0, 5), 1e-3});
  FakeEstimator estimator([&](const Frame& f) {
    test::Belief belief = test::true_belief(sequence, f);
    belief.landmarks = {landmark(0, Label::kStatic, 0, f.index, std::nullopt, 1),
                        landmark(1, Label::kStatic, 0, f.index, std::nullopt, 1)};
    belief.landmarks[0].by_rule = true;
    return belief;
  });
  EXPECT_TRUE(drive(sequence, estimator).classification.empty());
}

TEST(ClassificationTable, CountsAndRatios) {
  const auto record = [](Label truth, Label label) {
    return ClassificationRecord{0, truth, label, std::nullopt, 1};
  };
  std::vector<ClassificationRecord> records = {
      record(Label::kStatic, Label::kStatic), record(Label::kStatic, Label::kStatic),
      record(Label::kStatic, Label::kMoving), record(Label::kStatic, Label::kUnknown),
      record(Label::kMoving, Label::kMoving), record(Label::kMoving, Label::kStatic)};
  records.push_back({7, std::nullopt, Label::kMoving, 3, 2});
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
  FakeEstimator estimator([&](const Frame& f) {
    test::Belief belief = test::true_belief(sequence, f);
    belief.landmarks = {landmark(0, Label::kStatic, 1, f.index, 1, 1),
                        landmark(1, Label::kMoving, 1, f.index, 1, 1)};
    belief.landmarks[1].position = Eigen::Vector3d(0, 0, 5.5 + f.index);
    belief.landmarks[1].position_covariance.setIdentity();
    return belief;
  });
  const RunResult run = drive(sequence, estimator);
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
  FakeEstimator estimator([&](const Frame& f) {
    test::Belief belief = test::true_belief(sequence, f);
    belief.report.accepted = 10;
    belief.report.rejected = 2;
    belief.report.nis_sum = 17.0;
    return belief;
  });
  const RunMetrics metrics = compute_metrics(sequence, drive(sequence, estimator), 0.95);
  EXPECT_DOUBLE_EQ(metrics.nis.mean, 1.7);
  EXPECT_NEAR(metrics.nis.expected, 1.685, 5e-4);
  EXPECT_EQ(metrics.measurements.offered, 24);
}

}  // namespace
}  // namespace slammot
