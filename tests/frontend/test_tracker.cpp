// The front end by itself: patches under known warps, tracks of a shifted image, the same result
// from any number of threads, the noise measured, the chessboard.
#include <gtest/gtest.h>

#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "frontend/features/chessboard.h"
#include "frontend/tracking/noise.h"
#include "frontend/tracking/track_images.h"
#include "tests/eval/fixture.h"
#include "tests/frontend/texture.h"

namespace slammot {
namespace {

TEST(Patch, FindsAnAffineWarp) {
  const cv::Size size(120, 100);
  const Eigen::Vector2d centre(60.0, 50.0);
  const auto patch = Patch::cut(textured(size, {}), centre);
  ASSERT_TRUE(patch);
  Warp truth;
  truth.A << 1.1, 0.08, -0.06, 0.93;
  truth.t = Eigen::Vector2d(5.3, 2.6) + centre - truth.A * centre;
  const Eigen::Vector2d place = truth.A * centre + truth.t;
  cv::Mat image = textured(size, truth);
  image.convertTo(image, CV_8U, 0.7, 20.0);  // gain and bias
  const auto fit =
      patch->align(image, {Eigen::Matrix2d::Identity(), place + Eigen::Vector2d(1, -1)});
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->warp.t - place).norm(), 0.05);
  EXPECT_LT((fit->warp.A - truth.A).norm(), 0.02);
  EXPECT_GT(fit->correlation, 0.99);
}

// The sigma that an alignment states is that of its error: under noise, and twice as large under
// twice the noise.
TEST(Patch, StatesTheErrorOfItsPlace) {
  const cv::Size size(120, 100);
  const Eigen::Vector2d centre(60.0, 50.0);
  const cv::Mat exact = textured(size, {});
  const auto patch = Patch::cut(exact, centre);
  ASSERT_TRUE(patch);
  for (const double grey : {3.0, 6.0}) {
    std::mt19937_64 engine(5);
    std::normal_distribution<double> normal(0.0, grey);
    double squares = 0.0, stated = 0.0;
    constexpr int kImages = 200;
    for (int k = 0; k < kImages; ++k) {
      cv::Mat image = exact.clone();
      for (auto pixel = image.begin<uchar>(); pixel != image.end<uchar>(); ++pixel) {
        *pixel = cv::saturate_cast<uchar>(*pixel + normal(engine));
      }
      const auto fit = patch->align(image, {Eigen::Matrix2d::Identity(), centre});
      ASSERT_TRUE(fit);
      squares += (fit->warp.t - centre).squaredNorm() / 2.0;
      stated += fit->sigma * fit->sigma;
    }
    const double sigma = std::sqrt(squares / kImages);
    EXPECT_NEAR(std::sqrt(stated / kImages) / sigma, 1.0, 0.2) << sigma << " px";
  }
}

TEST(Patch, RefusesWhatCannotBePlaced) {
  EXPECT_FALSE(Patch::cut(cv::Mat(100, 100, CV_8U, cv::Scalar(90)), {50, 50}));  // no texture
  cv::Mat edge(100, 100, CV_8U, cv::Scalar(20));
  edge.colRange(50, 100).setTo(220);
  EXPECT_FALSE(Patch::cut(edge, {50, 50}));                     // slides along the edge
  EXPECT_FALSE(Patch::cut(textured({100, 100}, {}), {4, 50}));  // over the border
}

TEST(Tracker, FollowsAShift) {
  const cv::Size size(320, 240);
  Tracker tracker{TrackerOptions{}};
  const Eigen::Vector2d step(3.3, -1.7);
  std::map<int, Eigen::Vector2d> first;
  int followed = 0;
  for (int k = 0; k < 8; ++k) {
    Warp shift;
    shift.t = k * step;
    for (const Observation& z : tracker.process(textured(size, shift))) {
      const auto [at, fresh] = first.try_emplace(z.track, z.pixel - k * step);
      if (fresh) continue;
      EXPECT_LT((z.pixel - k * step - at->second).norm(), 0.1) << "frame " << k;
      ++followed;
    }
  }
  EXPECT_GT(followed, 100);
}

TEST(Tracker, CornersAreSpreadAndTrackNumbersNeverReturn) {
  Tracker tracker{TrackerOptions{}};
  const cv::Size size(320, 240);
  const double apart = cell_side(size, TrackerOptions{}.corners) / 2.0;
  const auto observations = tracker.process(textured(size, {}));
  ASSERT_GT(observations.size(), 20u);
  for (size_t i = 0; i < observations.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      EXPECT_GT((observations[i].pixel - observations[j].pixel).norm(), apart - 8.0);
    }
  }
  EXPECT_TRUE(tracker.process(cv::Mat(240, 320, CV_8U, cv::Scalar(90))).empty());
  for (const Observation& z : tracker.process(textured(size, {}))) {
    EXPECT_GT(z.track, observations.back().track);
  }
}

// 80 points in space before a moving camera, with a noise that is known: `sigma` and what is stated
// of each pixel, by track. Every fifth of them moves, if any.
struct PixelNoise {
  double sigma, relative;
};
Sequence points_seen(bool some_move, const std::function<PixelNoise(int track)>& noise_of) {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Sequence sequence;
  sequence.camera = {640, 480, 400.0, 400.0, 319.5, 239.5, PinholeLens{}};
  std::vector<Eigen::Vector3d> points, velocities;
  for (int i = 0; i < 80; ++i) {
    points.emplace_back(2.0 * unit(engine), 1.5 * unit(engine), 5.0 + 2.0 * unit(engine));
    velocities.emplace_back(Eigen::Vector3d::Zero());
    if (some_move && i % 5 == 0) velocities.back() = {0.05, 0.03 * unit(engine), 0.0};
  }
  for (int k = 0; k < 40; ++k) {
    Frame frame{k, 0.1 * k, {}, {}};
    const Eigen::Vector3d camera(0.03 * k, 0.01 * k, 0.02 * k);
    for (int i = 0; i < 80; ++i) {
      const auto p = static_cast<size_t>(i);
      const auto seen = sequence.camera.project(points[p] + k * velocities[p] - camera);
      const PixelNoise noise = noise_of(i);
      const Eigen::Vector2d error = noise.sigma * Eigen::Vector2d(normal(engine), normal(engine));
      frame.observations.push_back({i, seen->pixel + error, noise.relative});
    }
    sequence.frames.push_back(frame);
  }
  return sequence;
}

// Three quarters of all are 94% of those at rest: at most the quotient of these quantiles, 1.863 /
// 1.150, too much.
TEST(Noise, IsMeasuredAmongMovingPoints) {
  for (const double sigma : {0.1, 0.5}) {
    const auto noise = measure_noise(points_seen(true, [&](int) {
      return PixelNoise{sigma, 1.0};
    }));
    ASSERT_TRUE(noise);
    constexpr double kMost = 1.863 / 1.150;
    EXPECT_GT(noise->sigma, 0.9 * sigma);
    EXPECT_LT(noise->sigma, 1.1 * kMost * sigma);
    EXPECT_TRUE(noise->lower < noise->sigma && noise->sigma < noise->upper);
  }
}

// A part that is common to all, which is measured, and one of each measurement, which is known.
TEST(Noise, IsMeasuredBesideThatOfTheAlignment) {
  constexpr double kShared = 0.1;
  Sequence sequence = points_seen(false, [](int track) {
    const double own = track % 4 == 0 ? 0.3 : 0.02;
    return PixelNoise{std::hypot(kShared, kMismatch * own), own};
  });
  const auto noise = measure_noise(sequence, NoiseModel::kAlignment);
  ASSERT_TRUE(noise);
  EXPECT_NEAR(noise->sigma / kShared, 1.0, 0.25);
  state_noise(noise, NoiseModel::kAlignment, sequence);
  for (const Observation& z : sequence.frames.back().observations) {
    const double stated = std::sqrt(z.variance(sequence.pixel_sigma)) / kLasting;
    EXPECT_NEAR(stated, std::hypot(noise->sigma, kMismatch * (z.track % 4 == 0 ? 0.3 : 0.02)),
                1e-12);
  }
  Sequence unknown = sequence;
  state_noise(std::nullopt, NoiseModel::kAlignment, unknown);
  EXPECT_EQ(unknown.pixel_sigma, sequence.pixel_sigma);
  for (const Observation& z : unknown.frames.back().observations) EXPECT_EQ(z.relative_sigma, 1.0);
  state_noise(noise, NoiseModel::kCommon, sequence);
  for (const Observation& z : sequence.frames.back().observations) EXPECT_EQ(z.relative_sigma, 1.0);
  EXPECT_EQ(sequence.pixel_sigma, std::max(kLeastStated, noise->sigma));
}

TEST(Chessboard, GivesTheCameraInTheBoardsFrame) {
  Camera camera{640, 480, 500.0, 500.0, 319.5, 239.5, PinholeLens{}};
  const Chessboard board = parse_chessboard("6x5,0.05");
  CameraState truth;
  truth.position = {0.1, 0.12, -0.5};
  truth.orientation = exp_so3(Eigen::Vector3d(0.1, -0.15, 0.05));
  cv::Mat image(480, 640, CV_8U);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      double sum = 0.0;  // 5x5 samples of a pixel
      for (int k = 0; k < 25; ++k) {
        const Eigen::Vector2d pixel(u + (k % 5 - 2) / 5.0, v + (k / 5 - 2) / 5.0);
        const Eigen::Vector3d ray = truth.orientation * camera.unproject(pixel)->ray;
        const Eigen::Vector3d p = truth.position - ray * (truth.position.z() / ray.z());
        const int i = static_cast<int>(std::floor(p.x() / 0.05)),
                  j = static_cast<int>(std::floor(p.y() / 0.05));
        const bool inside = i >= -1 && i < 6 && j >= -1 && j < 5;
        sum += inside && (i + j) % 2 == 0 ? 20.0 : 230.0;
      }
      image.at<uchar>(v, u) = static_cast<uchar>(sum / 25.0);
    }
  }
  const auto view = find_chessboard(image, camera, board);
  ASSERT_TRUE(view);
  const CameraState& found = view->camera.state;
  EXPECT_LT((found.position - truth.position).norm(), 4.0 * view->camera.position_sigma);
  EXPECT_LT(log_so3(Eigen::Quaterniond(truth.orientation.conjugate() * found.orientation)).norm(),
            4.0 * view->camera.rotation_sigma);
  EXPECT_FALSE(find_chessboard(textured({640, 480}, {}), camera, board));
  for (const char* wrong :
       {"6x5", "6x5,0.05m", "4294967302x4294967301,0.05", "6x5,inf", "6,0.05", ""}) {
    EXPECT_THROW(parse_chessboard(wrong), std::invalid_argument) << wrong;
  }
}

}  // namespace
}  // namespace slammot
