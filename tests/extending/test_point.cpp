// A parametrisation of a point, as docs/extending.md adds one: what stands between the `example`
// and `end` lines is named there, and that it compiles is half the test.
#include <gtest/gtest.h>

#include <random>

#include "models/landmarks/landmark_models.h"
#include "models/landmarks/scaled_velocity.h"
#include "models/points/inverse_depth.h"
#include "models/points/observation.h"

namespace slammot {
namespace {

// [example: point parametrisation]
// Direction and distance: y = (theta, phi, d), rho = 1/d.
struct Distance {
  static constexpr std::string_view kName = "distance";
  static constexpr std::string_view kDescription = "(theta, phi, d)";
  static constexpr bool kLinearDepth = false;  // a prior of rho is not one of y

  template <typename T>
  static Vector3<T> direction(const Vector3<T>& y) {
    return InverseDepth::direction(y);
  }
  static Eigen::Matrix3d direction_jacobian(const Eigen::Vector3d& y) {
    return InverseDepth::direction_jacobian(y);
  }
  template <typename T>
  static T inverse_depth(const Vector3<T>& y) {
    return T(1.0) / y.z();
  }
  static Eigen::RowVector3d inverse_depth_jacobian(const Eigen::Vector3d& y) {
    return {0.0, 0.0, -1.0 / (y.z() * y.z())};
  }

  template <typename T>
  static Vector3<T> of(const Vector3<T>& g, const T& rho, const Vector3<T>& near) {
    return InverseDepth::of(g, T(T(1.0) / rho), near);
  }
  static Matrix34d of_jacobian(const Eigen::Vector3d& g, double rho) {
    Matrix34d J = InverseDepth::of_jacobian(g, rho);
    J(2, 3) = -1.0 / (rho * rho);
    return J;
  }
  static bool exists(const Eigen::Vector3d& g, double rho) { return !is_vertical(g) && rho != 0.0; }
};
static_assert(PointParametrisation<Distance>);
// [end]

constexpr PointFunctions kDistance = point_row<Distance>();

// With a model of motion, as registered it would be.
const LandmarkFunctions kLandmark = landmark_row<ScaledVelocity<Distance>>();

TEST(ExtendingPoint, JacobiansAreThoseOfTheFunctions) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 200; ++k) {
    LandmarkVector x(6);
    x << 3.0 * unit(engine), 1.4 * unit(engine), 4.0 + 3.0 * unit(engine), unit(engine),
        unit(engine), unit(engine);
    const Eigen::Vector3d y = x.head<3>();
    const LandmarkMatrix F = kLandmark.predict_jacobian(x, 0.1);
    const Eigen::Matrix3d J_position = position_jacobian(kDistance, y);
    for (int i = 0; i < 6; ++i) {
      const LandmarkVector d = kStep * Vector6d::Unit(i);
      const LandmarkVector moved = kLandmark.predict(x + d, 0.1) - kLandmark.predict(x - d, 0.1);
      EXPECT_LT((moved / (2.0 * kStep) - F.col(i)).norm(), 1e-7 * F.norm()) << "column " << i;
      if (i > 2) continue;
      const Eigen::Vector3d zero = Eigen::Vector3d::Zero(), dy = d.head<3>();
      const Eigen::Vector3d shifted =
          position_world(kDistance, zero, y + dy) - position_world(kDistance, zero, y - dy);
      EXPECT_LT((shifted / (2.0 * kStep) - J_position.col(i)).norm(), 1e-7 * J_position.norm());
    }
  }
}

TEST(ExtendingPoint, IsSeenWhereEveryOtherIs) {
  const Camera camera{640, 480, 385.0, 385.0, 319.5, 239.5, PinholeLens{}};
  const Eigen::Vector3d position(0.2, -0.1, 0.3), anchor(0.5, 0.0, 0.0), offset(0.4, 0.6, 4.0);
  const Eigen::Quaterniond R = Eigen::Quaterniond::Identity();
  const auto pixel = [&](const PointFunctions& point) {
    return observe(camera, point, position, R, anchor, point_at(point, offset)).value().pixel;
  };
  EXPECT_LT((pixel(kDistance) - pixel(point_table().front())).norm(), 1e-9);
}

}  // namespace
}  // namespace slammot
