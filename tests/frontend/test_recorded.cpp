// A recorded sequence with a board that fixes the scale, where it is present: from its images to
// metres, without alignment, as docs/recordings.md has it.
#include <gtest/gtest.h>

#include <filesystem>

#include "datasets/readers/image_reader.h"
#include "eval/configuration/configuration.h"
#include "eval/metrics/metrics.h"
#include "eval/run/run.h"
#include "frontend/tracking/track_images.h"
#include "tests/paths.h"

namespace slammot {
namespace {

TEST(Recorded, DeskIsKnownToACentimetre) {
  const std::filesystem::path folder = std::filesystem::path(test::kSharedData) / "desk_hand";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  TrackOptions options;
  options.chessboard = parse_chessboard("9x6,0.04");
  const Sequence sequence = track_images(read_images(folder), options).sequence;
  EXPECT_EQ(sequence.known.size(), 4u);
  for (const char* estimator : {"ekf", "window"}) {
    const RunResult run = run_estimator(sequence, {}, estimator);  // what a stranger gets
    ASSERT_FALSE(run.diverged);
    const RunMetrics metrics = compute_metrics(sequence, run, 0.95);
    ASSERT_TRUE(metrics.filtered.accuracy.value);
    const double rmse = metrics.filtered.accuracy.value->position_rmse;
    std::printf("desk_hand, %s: position RMSE %.4f m without alignment\n", estimator, rmse);
    EXPECT_LT(rmse, 0.01);
  }
}

// A car, and a camera that is jolted: one configuration, in which camera and first velocity are all
// that is stated. Bars: what docs/recordings.md has, and half as much again.
TEST(Recorded, OneConfigurationIsEnoughForACarAndAHand) {
  struct Recording {
    const char* name;
    double velocity_sigma;  // [m/s]
    double most;            // ATE after Sim(3), of the path
  };
  for (const auto& [name, velocity_sigma, most] :
       {Recording{"kitti00", 0.3, 0.017}, Recording{"synth19_images", 0.1, 0.008}}) {
    const std::filesystem::path folder = std::filesystem::path(test::kSharedData) / name;
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
    TrackOptions options;
    options.mixed_colours = true;
    Sequence sequence = track_images(read_images(folder), options).sequence;
    sequence.motion.reset();
    sequence.prior.reset();
    sequence.initial = InitialCamera{};
    sequence.initial->state = *sequence.truth.front();
    sequence.initial->velocity_sigma = velocity_sigma;
    sequence.initial->angular_velocity_sigma = 0.1;
    const RunResult run = run_estimator(sequence, {}, "ekf");
    ASSERT_FALSE(run.diverged);
    const RunMetrics metrics = compute_metrics(sequence, run, 0.95);
    ASSERT_TRUE(metrics.filtered.accuracy.value);
    double path = 0.0;
    for (std::size_t i = 1; i < sequence.truth.size(); ++i) {
      path += (sequence.truth[i]->position - sequence.truth[i - 1]->position).norm();
    }
    const double share = metrics.filtered.accuracy.value->ate_sim3 / path;
    std::printf("%s: %.2f%% of the path after Sim(3)\n", name, 100.0 * share);
    EXPECT_LT(share, most);
    EXPECT_FALSE(metrics.failed);
  }
}

// Cars among few static points: first estimates once ended the window at frame 9.
TEST(Recorded, FirstEstimatesRunThroughTraffic) {
  const std::filesystem::path folder = std::filesystem::path(test::kSharedData) / "kitti_traffic";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  const Sequence whole = track_images(read_images(folder), {}).sequence;
  const Sequence sequence = select_frames(whole, 0, 24, 1);
  Configuration configuration;
  configuration.window.linearisation = WindowLinearisation::kFej;
  const RunResult run = run_estimator(sequence, configuration, "window");
  EXPECT_FALSE(run.diverged);
  EXPECT_EQ(run.frames.size(), 25u);
}

}  // namespace
}  // namespace slammot
