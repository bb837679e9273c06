// How far pixels are from one line: 1 for noise alone, whatever camera and lens.
#include "eval/run/ray_spread.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "datasets/simulation/scenario.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

// Static landmarks of a line in space (or, with `across`, beside it), seen with 0.5 px of noise,
// every third with `uneven` times as much.
double spread_of_line(const Camera& camera, double angle, double across, double stated_sigma,
                      double uneven = 1.0) {
  std::mt19937 generator(1);
  std::normal_distribution<double> noise(0.0, 0.5);
  Frame frame{7, 0.0, {}, {}};
  std::vector<LandmarkEstimate> measured;
  for (int track = 0; track < 200; ++track) {
    const double along = -1.0 + 0.01 * track, beside = track % 2 == 0 ? across : -across;
    const Eigen::Vector2d point = Eigen::Rotation2Dd(angle) * Eigen::Vector2d(along, 0.1 + beside);
    const Eigen::Vector2d pixel = camera.project({point.x(), point.y(), 2.0})->pixel;
    const double relative = track % 3 == 0 ? uneven : 1.0;
    frame.observations.push_back(
        {track,
         {pixel.x() + relative * noise(generator), pixel.y() + relative * noise(generator)},
         relative});
    measured.emplace_back();
    measured.back().track = track;
    measured.back().label = Label::kStatic;
    measured.back().last_frame = 7;
  }
  return ray_spread(camera, stated_sigma, frame, measured);
}

TEST(RaySpread, OfALineIsThatOfTheNoise) {
  const std::vector<double> bend{-0.2, 0.05, 0.001, 0.0, 0.0};
  for (const LensModel& lens : {LensModel(PinholeLens{}), make_lens("radtan", bend)}) {
    for (const double fy : {200.0, 400.0}) {
      const Camera camera{640, 480, 400.0, fy, 320.0, 240.0, lens};
      for (const double angle : {0.0, 0.8, 1.5}) {
        SCOPED_TRACE(testing::Message() << lens_name(lens) << " fy " << fy << " angle " << angle);
        EXPECT_NEAR(spread_of_line(camera, angle, 0.0, 0.5), 1.0, 0.12);
        EXPECT_NEAR(spread_of_line(camera, angle, 0.0, 1.0), 0.5, 0.06);
        EXPECT_NEAR(spread_of_line(camera, angle, 0.0, 0.5, 5.0), 1.0, 0.12);
      }
      EXPECT_NEAR(spread_of_line(camera, 0.0, 0.1, 0.5) / (0.1 / 2.0 * fy / 0.5), 1.0, 0.12);
    }
  }
}

// Not in the sequence's, and with given labels of the same landmarks.
TEST(RaySpread, IsInTheSigmaOfTheEstimator) {
  const Sequence sequence = simulate("circle", {{"frames", "2"}}, 1);
  Configuration twice;
  twice.pixel_sigma = 2.0 * sequence.pixel_sigma;
  const auto first = [&](const Configuration& configuration) {
    return run_estimator(sequence, configuration, "true_labels").ray_spread.front();
  };
  EXPECT_NEAR(first({}) / first(twice), 2.0, 1e-9);
}

TEST(RaySpread, OfNothingIsUndefined) {
  EXPECT_TRUE(std::isnan(ray_spread(Camera{}, 1.0, Frame{7, 0.0, {}, {}}, {})));
}

}  // namespace
}  // namespace slammot
