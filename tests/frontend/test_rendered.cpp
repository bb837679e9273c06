// From pixels to NEES, without outside data: a short rendered sequence through front end, EKF and
// window.
//
// The NEES of one run is judged roughly only: the errors of a track are not white (its patch has
// one error for long), which no estimator here models. Judged are what the rest must give: the
// noise measured against the true one, the path, the labels.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>

#include "datasets/native/native_reader.h"
#include "datasets/native/native_writer.h"
#include "datasets/readers/image_reader.h"
#include "eval/metrics/metrics.h"
#include "eval/run/run.h"
#include "frontend/rendering/render.h"
#include "frontend/tracking/noise.h"
#include "frontend/tracking/track_images.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

struct PixelError {
  double error;  // of one coordinate [px]
  double stated_sigma;
};

// Of all but the first measurement of each static track: the first one defines the point.
std::vector<PixelError> pixel_errors(const Sequence& sequence) {
  std::vector<PixelError> errors;
  std::set<int> seen;
  for (size_t i = 0; i < sequence.frames.size(); ++i) {
    const CameraState& camera = *sequence.truth[i];
    for (const Observation& z : sequence.frames[i].observations) {
      const TrueLandmark& landmark = sequence.landmarks.at(z.track);
      if (landmark.label != Label::kStatic || seen.insert(z.track).second) continue;
      const Eigen::Vector3d ray =
          camera.orientation.conjugate() * (landmark.at(0)->position - camera.position);
      const Eigen::Vector2d error = z.pixel - sequence.camera.project(ray)->pixel;
      const double stated = std::sqrt(z.variance(sequence.pixel_sigma));
      for (const double e : error) errors.push_back({std::abs(e), stated});
    }
  }
  return errors;
}

double quantile(std::span<PixelError> errors, double part) {
  std::ranges::sort(errors, {}, &PixelError::error);
  return errors[static_cast<size_t>(part * static_cast<double>(errors.size()))].error;
}

class Rendered : public ::testing::Test {
 protected:
  // One thread: ThreadSanitizer does not see that OpenCV's threads wait for each other (tsan.supp).
  static void SetUpTestSuite() {
    cv::setNumThreads(1);
    write_room({}, {{"frames", "45"}, {"k1", "-0.1"}, {"width", "320"}}, 1, folder() / "room");
    TrackOptions options;
    options.threads = 1;
    TrackedImages tracked = track_images(read_images(folder() / "room"), options);
    add_room_truth(folder() / "room", tracked.sequence);
    write_native(tracked.sequence, folder() / "tracked");
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder()); }
  static std::filesystem::path folder() {
    return std::filesystem::temp_directory_path() / ("slammot-room-" + std::to_string(getpid()));
  }
  static Sequence tracked() { return read_native(folder() / "tracked"); }
  static Sequence tracked_by_alignment() {
    TrackOptions options;
    options.threads = 1;
    options.noise = NoiseModel::kAlignment;
    TrackedImages tracked = track_images(read_images(folder() / "room"), options);
    add_room_truth(folder() / "room", tracked.sequence);
    write_native(tracked.sequence, folder() / "by_alignment");
    return read_native(folder() / "by_alignment");
  }
};

TEST_F(Rendered, TheSameSeedGivesTheSameImagesOnAnyNumberOfThreads) {
  RoomOptions options;
  options.width = 64;
  options.height = 48;
  options.exposure = 0.02;
  const auto image = [&](std::uint64_t seed) {
    return render(Room(options, seed), options, seed, 3);
  };
  const cv::Mat alone = image(5);
  EXPECT_GT(cv::norm(alone, image(6), cv::NORM_INF), 0.0);
#ifndef __SANITIZE_THREAD__
  cv::setNumThreads(-1);
#endif
  EXPECT_EQ(cv::norm(alone, image(5), cv::NORM_INF), 0.0);
}

TEST_F(Rendered, TheTruthIsThereForEveryTrack) {
  const Sequence sequence = tracked();
  EXPECT_TRUE(sequence.exact_truth);
  EXPECT_EQ(sequence.known.size(), 4u);
  int moving = 0;
  for (const auto& [track, landmark] : sequence.landmarks) {
    moving += landmark.label == Label::kMoving ? 1 : 0;
  }
  EXPECT_GT(moving, 5);
  for (const Observation& z : sequence.frames.front().observations) {
    EXPECT_EQ(sequence.landmarks.at(z.track).label, Label::kStatic);
  }
}

TEST_F(Rendered, TheNoiseMeasuredIsThatOfTheTracks) {
  const Sequence sequence = tracked();
  std::vector<PixelError> errors = pixel_errors(sequence);
  const double sigma = 1.4826 * quantile(errors, 0.5);
  const auto noise = measure_noise(sequence);
  ASSERT_TRUE(noise);
  std::printf("noise measured %.3f px; true, robustly %.3f px, 90%% below %.3f px\n", noise->sigma,
              sigma, quantile(errors, 0.9));
  EXPECT_GT(noise->sigma, sigma / 2.0);
  EXPECT_LT(noise->sigma, sigma * 2.0);
  EXPECT_EQ(sequence.pixel_sigma, kLeastStated);
}

// The third that is stated to be the most exact against the third stated to be the least.
TEST_F(Rendered, TheSigmasByAlignmentAreThoseOfTheErrors) {
  std::vector<PixelError> errors = pixel_errors(tracked_by_alignment());
  std::ranges::sort(errors, {}, &PixelError::stated_sigma);
  const std::span all(errors);
  const size_t third = all.size() / 3;
  const double best_stated = all[third / 2].stated_sigma;
  const double worst_stated = all[all.size() - third / 2].stated_sigma;
  const double best = quantile(all.first(third), 0.5), worst = quantile(all.last(third), 0.5);
  std::printf("stated %.3f and %.3f px, median errors %.3f and %.3f px\n", best_stated,
              worst_stated, best, worst);
  EXPECT_GT(worst_stated, 1.5 * best_stated);
  EXPECT_GT(worst, 1.5 * best);
  EXPECT_LT(1.4826 * best, 2.0 * best_stated);
  EXPECT_LT(1.4826 * worst, 2.0 * worst_stated);
}

// A measurement's own fit, not that of its track.
TEST_F(Rendered, TheSigmasByAlignmentChangeAlongATrack) {
  std::map<int, std::set<double>> of_track;
  int measurements = 0;
  for (const Frame& frame : tracked_by_alignment().frames) {
    for (const Observation& z : frame.observations) {
      of_track[z.track].insert(z.relative_sigma);
      ++measurements;
    }
  }
  int different = 0;
  for (const auto& [track, sigmas] : of_track) different += static_cast<int>(sigmas.size());
  EXPECT_GT(different, measurements * 9 / 10);
}

TEST_F(Rendered, FromPixelsToNees) {
  const Sequence sequence = tracked();
  for (const char* estimator : {"ekf", "window"}) {
    const RunResult run = run_estimator(sequence, Configuration{}, estimator);
    ASSERT_FALSE(run.diverged) << estimator;
    const RunMetrics metrics = compute_metrics(sequence, run, 0.95);
    ASSERT_TRUE(metrics.filtered.accuracy.value && metrics.filtered.consistency.value);
    const Accuracy& accuracy = *metrics.filtered.accuracy.value;
    std::printf("%s: position RMSE %.4f m, pose NEES %.1f (6 expected of white noise)\n", estimator,
                accuracy.position_rmse, metrics.filtered.consistency.value->pose.mean);
    EXPECT_LT(accuracy.position_rmse, 0.02);  // of a path of 1.7 m
    EXPECT_GT(metrics.filtered.consistency.value->pose.mean, 1.0);
    EXPECT_LT(metrics.filtered.consistency.value->pose.mean, 20.0);
    const auto& labels = metrics.classification;
    EXPECT_LE(labels.statics.wrong, labels.statics.right / 20);
    EXPECT_EQ(labels.movings.wrong, 0);
  }
}

}  // namespace
}  // namespace slammot
