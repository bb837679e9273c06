// From pixels to NEES, without outside data: a short rendered sequence through front end, EKF and
// window.
//
// The NEES of one run is judged roughly only: the errors of a track are not white (its patch has
// one error for long), which no estimator here models. Judged are what the rest must give: the
// noise measured against the true one, the path, the labels.
#include <gtest/gtest.h>

#include <algorithm>
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

// One thread: ThreadSanitizer does not see that OpenCV's threads wait for each other (tsan.supp).
class Rendered : public ::testing::Test {
 protected:
  Rendered() {
    cv::setNumThreads(1);
    write_room({}, {{"frames", "45"}, {"k1", "-0.1"}, {"width", "320"}}, 1, room());
  }
  std::filesystem::path room() const { return folder_.path() / "room"; }
  Sequence tracked(NoiseModel noise) const {
    TrackOptions options;
    options.threads = 1;
    options.noise = noise;
    TrackedImages tracked = track_images(read_images(room()), options);
    add_room_truth(room(), tracked.sequence);
    write_native(tracked.sequence, folder_.path() / "tracked");
    return read_native(folder_.path() / "tracked");
  }

  test::TemporaryFolder folder_;
};

TEST(RenderedRoom, IsTheSameOnAnyNumberOfThreadsForTheSameSeed) {
  RoomOptions options;
  options.width = 64;
  options.height = 48;
  options.exposure = 0.02;
  const auto image = [&](std::uint64_t seed) {
    return render(Room(options, seed), options, seed, 3);
  };
  cv::setNumThreads(1);
  const cv::Mat alone = image(5);
  EXPECT_GT(cv::norm(alone, image(6), cv::NORM_INF), 0.0);
#ifndef __SANITIZE_THREAD__
  cv::setNumThreads(-1);
#endif
  EXPECT_EQ(cv::norm(alone, image(5), cv::NORM_INF), 0.0);
}

// The truth of every track, the noise measured, both families.
TEST_F(Rendered, FromPixelsToNees) {
  const Sequence sequence = tracked(NoiseModel::kCommon);
  EXPECT_TRUE(sequence.exact_truth);
  EXPECT_EQ(sequence.known.size(), 4u);
  EXPECT_GT(std::ranges::count(sequence.landmarks, Label::kMoving,
                               [](const auto& entry) { return entry.second.label; }),
            5);
  for (const Observation& z : sequence.frames.front().observations) {
    EXPECT_EQ(sequence.landmarks.at(z.track).label, Label::kStatic);
  }
  std::vector<PixelError> errors = pixel_errors(sequence);
  const double sigma = 1.4826 * quantile(errors, 0.5);
  const auto noise = measure_noise(sequence);
  ASSERT_TRUE(noise);
  EXPECT_GT(noise->sigma, sigma / 2.0);
  EXPECT_LT(noise->sigma, sigma * 2.0);
  EXPECT_EQ(sequence.pixel_sigma, kLeastStated);
  for (const char* estimator : {"ekf", "window"}) {
    SCOPED_TRACE(estimator);
    const RunResult run = run_estimator(sequence, Configuration{}, estimator);
    ASSERT_FALSE(run.diverged);
    const RunMetrics metrics = compute_metrics(sequence, run, 0.95);
    ASSERT_TRUE(metrics.filtered.accuracy.value && metrics.filtered.consistency.value);
    EXPECT_LT(metrics.filtered.accuracy.value->position_rmse, 0.02);  // of a path of 1.7 m
    EXPECT_GT(metrics.filtered.consistency.value->pose.mean, 1.0);
    EXPECT_LT(metrics.filtered.consistency.value->pose.mean, 20.0);
    const auto& labels = metrics.classification;
    EXPECT_LE(labels.statics.wrong, labels.statics.right / 20);
    EXPECT_EQ(labels.movings.wrong, 0);
  }
}

// The third that is stated to be the most exact against the third stated to be the least. It is a
// measurement's own fit that is stated, not that of its track.
TEST_F(Rendered, TheSigmasByAlignmentAreThoseOfTheErrors) {
  const Sequence sequence = tracked(NoiseModel::kAlignment);
  std::vector<PixelError> errors = pixel_errors(sequence);
  std::ranges::sort(errors, {}, &PixelError::stated_sigma);
  const std::span all(errors);
  const size_t third = all.size() / 3;
  const double best_stated = all[third / 2].stated_sigma;
  const double worst_stated = all[all.size() - third / 2].stated_sigma;
  const double best = quantile(all.first(third), 0.5), worst = quantile(all.last(third), 0.5);
  EXPECT_GT(worst_stated, 1.5 * best_stated);
  EXPECT_GT(worst, 1.5 * best);
  EXPECT_LT(1.4826 * best, 2.0 * best_stated);
  EXPECT_LT(1.4826 * worst, 2.0 * worst_stated);

  std::set<std::pair<int, double>> different;  // of a track
  std::size_t measurements = 0;
  for (const Frame& frame : sequence.frames) {
    measurements += frame.observations.size();
    for (const Observation& z : frame.observations) different.insert({z.track, z.relative_sigma});
  }
  EXPECT_GT(different.size(), measurements * 9 / 10);
}

}  // namespace
}  // namespace slammot
