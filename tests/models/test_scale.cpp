// A change of the world's scale, as a landmark's y shows it.
#include "models/points/scale.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slammot {
namespace {

TEST(Scale, ADirectionStaysAndDepthsGrow) {
  for (const PointFunctions& point : point_table()) {
    const Eigen::Vector3d g = Eigen::Vector3d(0.3, -0.2, 0.9).normalized();
    const Eigen::Vector3d y = point.of(g, 0.4, Eigen::Vector3d::Zero());
    const PointRay ray = point.ray(scaled(point, y, 0.7));
    EXPECT_LT((ray.direction - g).norm(), 1e-12) << point.name;
    EXPECT_NEAR(ray.inverse_depth, 0.4 * std::exp(-0.7), 1e-12) << point.name;
    EXPECT_LT((scaled(point, scaled(point, y, 0.5), -0.5) - y).norm(), 1e-12) << point.name;
  }
}

TEST(Scale, JacobianAndDirectionAreDerivatives) {
  constexpr double kStep = 1e-6;
  for (const PointFunctions& point : point_table()) {
    const Eigen::Vector3d g(0.3, -0.2, 0.9);
    const Eigen::Vector3d y = point.of(g, 0.4, Eigen::Vector3d::Zero());
    const Eigen::Matrix3d J = scaled_jacobian(point, y, 0.3);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(k);
      const Eigen::Vector3d numeric =
          (scaled(point, y + d, 0.3) - scaled(point, y - d, 0.3)) / (2.0 * kStep);
      EXPECT_LT((numeric - J.col(k)).norm(), 1e-8) << point.name;
    }
    const Eigen::Vector3d along =
        (scaled(point, y, kStep) - scaled(point, y, -kStep)) / (2.0 * kStep);
    EXPECT_LT((along - along_scale(point, y)).norm(), 1e-8) << point.name;
  }
}

}  // namespace
}  // namespace slammot
