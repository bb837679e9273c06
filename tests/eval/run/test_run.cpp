// Driving an estimator: what is collected, what divergence leaves.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "eval/metrics/metrics.h"
#include "eval/output/metrics_json.h"
#include "eval/run/process.h"
#include "eval/run/run.h"
#include "eval/run/stage_clock.h"
#include "eval/trajectory/align_run.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

using test::driven;
using test::FakeEstimator;
using test::landmark;

TEST(Drive, CollectsFramesAndTimes) {
  int calls = 0;
  DriveOptions options;
  options.progress = [&](int done, int total) {
    EXPECT_EQ(done, ++calls);
    EXPECT_EQ(total, 4);
  };
  const RunResult run = driven(
      test::straight_line(4), [](int, auto&) {}, options);
  EXPECT_EQ(calls, 4);
  EXPECT_EQ(run.frames, (std::vector{0, 1, 2, 3}));
  ASSERT_EQ(run.timing.size(), 12u);  // predict, update and total of each frame
  EXPECT_EQ(run.timing[2].stage, "total");
  EXPECT_GE(run.timing[2].milliseconds, run.timing[0].milliseconds + run.timing[1].milliseconds);
  EXPECT_FALSE(run.diverged);
}

// A winding path of 20 poses from (1, 2, 3) on.
Sequence winding() {
  Sequence sequence = test::straight_line(20);
  for (std::size_t i = 0; i < sequence.truth.size(); ++i) {
    const double a = 0.3 * static_cast<double>(i);
    sequence.truth[i]->position =
        Eigen::Vector3d(1, 2, 3) + a * Eigen::Vector3d(std::cos(a), 0.1 * a, std::sin(a));
  }
  return sequence;
}

// The true path, each pose in the scale that is believed then: frame k makes the world e^changes[k]
// as large.
RunResult in_changing_scale(const Sequence& sequence, const std::vector<double>& changes,
                            bool batch = false) {
  DriveOptions options;
  options.batch = batch;
  double log_scale = 0.0;
  return driven(
      sequence,
      [&](int i, test::Belief& belief) {
        belief.report.scale_change = changes.at(static_cast<std::size_t>(i));
        log_scale += belief.report.scale_change;
        Eigen::Vector3d& r = belief.camera.state.position;
        const Eigen::Vector3d origin = sequence.truth[0]->position;
        r = origin + std::exp(log_scale) * (r - origin);
      },
      options);
}

TEST(LastScale, AChangeLeavesTheShapeUndisturbed) {
  const Sequence sequence = winding();
  for (const std::size_t k : {1u, 7u, 19u}) {
    std::vector<double> changes(20, 0.0);
    changes[k] = 0.4;
    changes[4] = -0.1;
    const RunResult run = in_changing_scale(sequence, changes);
    const RunMetrics metrics = compute_metrics(sequence, run, 0.95);
    ASSERT_TRUE(metrics.last_scale);
    EXPECT_GT(metrics.filtered.accuracy.value->ate_sim3, 1e-3);
    EXPECT_LT(metrics.last_scale->accuracy.value->ate_sim3, 1e-12);
    EXPECT_NEAR(metrics.last_scale->accuracy.value->scale, std::exp(0.1 - 0.4), 1e-12);
    EXPECT_EQ(run.last_scale.back().state.position, run.filtered.back().state.position);
    EXPECT_TRUE(run.last_scale.back().covariance.array().isNaN().all());
    RunResult aligned = run;  // each by a fit of its own
    align_run(sequence, AlignBy::kSim3, aligned);
    const RunMetrics after = compute_metrics(sequence, aligned, 0.95);
    EXPECT_LT(after.last_scale->accuracy.value->position_rmse, 1e-12);
  }
}

TEST(LastScale, IsNotThereWhereTheScaleIsKnown) {
  const Sequence sequence = winding();
  const RunResult known = driven(sequence);  // states no change
  EXPECT_TRUE(known.last_scale.empty());
  const RunMetrics metrics = compute_metrics(sequence, known, 0.95);
  EXPECT_FALSE(metrics.last_scale);
  EXPECT_FALSE(metrics_json(metrics).contains("last_scale"));
  EXPECT_TRUE(in_changing_scale(sequence, std::vector(20, 0.0), true).last_scale.empty());
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

TEST(Drive, ADivergedRunKeepsWhatWasFinished) {
  const Sequence sequence = test::straight_line(5);
  const RunResult run = driven(sequence, [](int frame, auto&) {
    if (frame == 3) throw Diverged("covariance is not positive");
  });
  ASSERT_TRUE(run.diverged);
  EXPECT_EQ(run.diverged->frame, 3);
  EXPECT_EQ(run.diverged->reason, "covariance is not positive");
  EXPECT_EQ(run.filtered.size(), 3u);
  EXPECT_EQ(run.frames_offered, 5);
  EXPECT_EQ(metrics_json(compute_metrics(sequence, run, 0.95))["diverged"], true);
}

// A camera that is merely lost is none of it.
TEST(Drive, WhatCannotBeIsDivergence) {
  const Sequence sequence = test::straight_line(5);
  using Spoil = void (*)(CameraEstimate&);
  for (const Spoil spoil : {Spoil([](CameraEstimate& c) { c.covariance(3, 4) = kUndefined; }),
                            Spoil([](CameraEstimate& c) { c.state.velocity.x() = kUndefined; }),
                            Spoil([](CameraEstimate& c) { c.state.position.x() = 1e150; })}) {
    const RunResult run = driven(sequence, [=](int frame, auto& belief) {
      if (frame == 2) spoil(belief.camera);
    });
    ASSERT_TRUE(run.diverged);
    EXPECT_EQ(run.diverged->frame, 2);
    EXPECT_EQ(run.filtered.size(), 2u);
  }
  const auto lost = [](int, auto& belief) { belief.camera.state.position.x() = 1e6; };
  EXPECT_FALSE(driven(sequence, lost).diverged);
}

// A landmark that leaves keeps its latest belief; one that comes back anew replaces it.
TEST(Drive, LandmarksAreRememberedAfterTheyLeave) {
  const RunResult run = driven(test::straight_line(6), [](int i, auto& belief) {
    if (i <= 2) {
      belief.landmarks = {i < 1 ? landmark(0, Label::kUnknown, 0, i, std::nullopt, i + 1)
                                : landmark(0, Label::kStatic, 0, i, 1, i + 1),
                          landmark(1, Label::kStatic, 0, i, 0, i + 1)};
    }
    if (i == 3) belief.report.retired = {landmark(1, Label::kMoving, 0, 2, 3, 3)};
    if (i >= 4) belief.landmarks = {landmark(0, Label::kUnknown, 4, i, std::nullopt, i - 3)};
  });
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
  const RunResult run = driven(sequence, [](int i, auto& belief) {
    belief.landmarks = {i < 2 ? landmark(1, Label::kUnknown, 0, i, std::nullopt, i + 1)
                              : landmark(1, Label::kMoving, 0, i, 2, i + 1)};
  });
  ASSERT_EQ(run.classification.size(), 1u);
  EXPECT_EQ(run.classification[0].observations, 3);
  EXPECT_EQ(compute_metrics(sequence, run, 0.95).classification.median_frames_to_decision, 3.0);
}

TEST(Drive, LandmarksByRuleAreNotClassified) {
  Sequence sequence = test::straight_line(2);
  sequence.known.push_back({1, Eigen::Vector3d(0, 0, 5), 1e-3});
  const RunResult run = driven(sequence, [](int i, auto& belief) {
    belief.landmarks = {landmark(0, Label::kStatic, 0, i, std::nullopt, 1),
                        landmark(1, Label::kStatic, 0, i, std::nullopt, 1)};
    belief.landmarks[0].by_rule = true;
  });
  EXPECT_TRUE(run.classification.empty());
}

// A processor with AVX-512 that OpenBLAS takes for a Haswell one; what the user states decides.
TEST(Process, BetterKernelsWhereOpenBlasDoesNotKnowTheProcessor) {
  EXPECT_EQ(better_kernels(true, "Haswell", false), "SkylakeX");
  EXPECT_EQ(better_kernels(true, "Haswell", true), std::nullopt);
  EXPECT_EQ(better_kernels(true, "SkylakeX", false), std::nullopt);  // as after the new start
  EXPECT_EQ(better_kernels(false, "Haswell", false), std::nullopt);
  EXPECT_EQ(better_kernels(false, "Zen", false), std::nullopt);
}

}  // namespace
}  // namespace slammot
