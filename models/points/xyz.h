// Euclidean coordinates seen from the anchor: y = x_W - a [m]. Neither infinity nor what lies
// behind it has a y.
#pragma once

#include "models/points/point.h"

namespace slammot {

struct Xyz {
  static constexpr std::string_view kName = "xyz";
  static constexpr std::string_view kDescription = "Euclidean, from the anchor";
  static constexpr bool kLinearDepth = false;

  template <typename T>
  static Vector3<T> direction(const Vector3<T>& y) {
    return y / y.norm();
  }
  static Eigen::Matrix3d direction_jacobian(const Eigen::Vector3d& y) { return unit_jacobian(y); }
  template <typename T>
  static T inverse_depth(const Vector3<T>& y) {
    return T(1.0) / y.norm();
  }
  static Eigen::RowVector3d inverse_depth_jacobian(const Eigen::Vector3d& y) {
    const double n = y.norm();
    return -y.transpose() / (n * n * n);
  }

  template <typename T>
  static Vector3<T> of(const Vector3<T>& g, const T& rho, const Vector3<T>& /*near*/) {
    return g / T(g.norm() * rho);
  }
  static Matrix34d of_jacobian(const Eigen::Vector3d& g, double rho) {
    Matrix34d J;
    J << unit_jacobian(g) / rho, -g / (g.norm() * rho * rho);
    return J;
  }
  static bool exists(const Eigen::Vector3d& /*g*/, double rho) { return rho > 0.0; }
};

static_assert(PointParametrisation<Xyz>);

}  // namespace slammot
