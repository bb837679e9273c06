// A recorded sequence with a board that fixes the scale, where it is present: from its images to
// metres, without alignment (docs/recordings.md).
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

constexpr double kCarVelocitySigma = 0.3, kHandVelocitySigma = 0.1;  // [m/s]

bool is_here(const char* name) {
  return std::filesystem::exists(std::filesystem::path(test::kSharedData) / name);
}

// Camera and scale, and nothing that the recording says of motion and depths: what
// bench/real_images.py states.
Sequence tracked(const char* name, const TrackOptions& options, int last = -1) {
  const Sequence images = read_images(std::filesystem::path(test::kSharedData) / name);
  Sequence sequence = track_images(select_frames(images, 0, last, 1), options).sequence;
  sequence.motion.reset();
  sequence.prior.reset();
  return sequence;
}

TEST(Recorded, DeskIsKnownToACentimetre) {
  if (!is_here("desk_hand")) GTEST_SKIP() << "desk_hand is not here";
  TrackOptions options;
  options.chessboard = parse_chessboard("9x6,0.04");
  const Sequence sequence = tracked("desk_hand", options);
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

double path_of(const Sequence& sequence) {
  double path = 0.0;
  for (std::size_t i = 1; i < sequence.truth.size(); ++i) {
    path += (sequence.truth[i]->position - sequence.truth[i - 1]->position).norm();
  }
  return path;
}

// A car, and a camera that is jolted: one configuration, in which camera and first velocity are all
// that is stated. Bars: what was measured, and half as much again, since OpenCV's tracks
// differ from machine to machine.
TEST(Recorded, OneConfigurationIsEnoughForACarAndAHand) {
  struct Recording {
    const char* name;
    double velocity_sigma;
    double most_of_ekf, most_of_window;  // ATE after Sim(3), of the path
  };
  for (const auto& [name, velocity_sigma, most_of_ekf, most_of_window] :
       {Recording{"kitti00", kCarVelocitySigma, 0.0141, 0.0131},
        Recording{"synth19_images", kHandVelocitySigma, 0.0065, 0.003}}) {
    if (!is_here(name)) GTEST_SKIP() << name << " is not here";
    TrackOptions options;
    options.mixed_colours = true;
    Sequence sequence = tracked(name, options);
    sequence.initial = InitialCamera{};
    sequence.initial->state = *sequence.truth.front();
    sequence.initial->velocity_sigma = velocity_sigma;
    sequence.initial->angular_velocity_sigma = 0.1;
    for (const auto& [estimator, most] :
         {std::pair{"ekf", most_of_ekf}, std::pair{"window", most_of_window}}) {
      const RunResult run = run_estimator(sequence, {}, estimator);
      ASSERT_FALSE(run.diverged);
      const RunMetrics metrics = compute_metrics(sequence, run, 0.95);
      ASSERT_TRUE(metrics.filtered.accuracy.value);
      const double share = metrics.filtered.accuracy.value->ate_sim3 / path_of(sequence);
      std::printf("%s, %s: %.2f%% of the path after Sim(3)\n", name, estimator, 100.0 * share);
      EXPECT_LT(share, most);
      EXPECT_FALSE(metrics.failed);
    }
  }
}

// Cars among few static points: first estimates once ended the window at frame 9.
TEST(Recorded, FirstEstimatesRunThroughTraffic) {
  if (!is_here("kitti_traffic")) GTEST_SKIP() << "kitti_traffic is not here";
  const Sequence sequence = tracked("kitti_traffic", {}, 24);
  Configuration configuration;
  configuration.window.linearisation = WindowLinearisation::kFej;
  const RunResult run = run_estimator(sequence, configuration, "window");
  EXPECT_FALSE(run.diverged);
  EXPECT_EQ(run.frames.size(), 25u);
}

}  // namespace
}  // namespace slammot
