// A landmark model, as examples/extension/ adds one; its code stands there.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "estimation/landmark_estimate.h"
#include "examples/extension/decaying_velocity.h"
#include "models/landmarks/landmark.h"
#include "models/points/inverse_depth.h"
#include "models/points/point_functions.h"

namespace slammot {
namespace {

using Decaying = DecayingVelocity<InverseDepth>;
const PointFunctions& kPoint = find_point("inverse_depth");

Vector6d random_landmark(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Vector6d x;
  x << 3.0 * unit(engine), 1.4 * unit(engine), 0.4 + 0.5 * unit(engine), 2.0 * unit(engine),
      2.0 * unit(engine), 2.0 * unit(engine);
  return x;
}

TEST(ExtendingLandmark, JacobianIsThatOfThePrediction) {
  std::mt19937_64 engine(1);
  for (int k = 0; k < 500; ++k) {
    const Vector6d x = random_landmark(engine);
    const double dt = 0.02 + 0.001 * (k % 100);
    const Matrix6d F = Decaying::predict_jacobian(x, dt);
    for (int i = 0; i < 6; ++i) {
      constexpr double kStep = 1e-5;
      const Vector6d d = kStep * Vector6d::Unit(i);
      const Vector6d numeric =
          (Decaying::predict(Vector6d(x + d), dt) - Decaying::predict(Vector6d(x - d), dt)) /
          (2.0 * kStep);
      ASSERT_LT((numeric - F.col(i)).norm(), 1e-7 * F.norm()) << x.transpose() << ", column " << i;
    }
  }
}

TEST(ExtendingLandmark, MovesAndNoiseStandsInMetres) {
  std::mt19937_64 engine(2);
  for (int k = 0; k < 100; ++k) {
    const Vector6d x = random_landmark(engine);
    if (std::abs(x(2)) < 1e-2) continue;
    // Two half steps are one step: the prediction is that of a differential equation.
    const Vector6d halves = Decaying::predict(Decaying::predict(x, 0.05), 0.05);
    EXPECT_LT((halves - Decaying::predict(x, 0.1)).norm(), 1e-12);
    Matrix6d J_metric = Matrix6d::Zero();
    J_metric.topLeftCorner<3, 3>() = position_jacobian(kPoint, x.head<3>());
    J_metric.bottomRows<3>() = Decaying::velocity_jacobian(x);
    const Matrix6d I = Decaying::noise_jacobian(x) * J_metric;
    EXPECT_LT((I - Matrix6d::Identity()).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_TRUE(landmark_noise_root<Decaying>(x, LandmarkPrior{}, 0.1).allFinite());
  }
}

}  // namespace
}  // namespace slammot
