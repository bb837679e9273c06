// The logarithm of inverse depth (Parsley & Julier 2008): y = (theta, phi, ln rho), rho in 1/m. No
// depth is negative, and none infinite.
#pragma once

#include "models/points/inverse_depth.h"

namespace slammot {

struct LogInverseDepth {
  static constexpr std::string_view kName = "log_inverse_depth";
  static constexpr std::string_view kDescription = "(theta, phi, ln rho), Parsley & Julier 2008";
  static constexpr bool kLinearDepth = false;

  template <typename T>
  static Vector3<T> direction(const Vector3<T>& y) {
    return InverseDepth::direction(y);
  }
  static Eigen::Matrix3d direction_jacobian(const Eigen::Vector3d& y) {
    return InverseDepth::direction_jacobian(y);
  }
  template <typename T>
  static T inverse_depth(const Vector3<T>& y) {
    using std::exp;
    return exp(y.z());
  }
  static Eigen::RowVector3d inverse_depth_jacobian(const Eigen::Vector3d& y) {
    return {0.0, 0.0, inverse_depth(y)};
  }

  template <typename T>
  static Vector3<T> of(const Vector3<T>& g, const T& rho, const Vector3<T>& near) {
    using std::log;
    return InverseDepth::of(g, T(log(rho)), near);
  }
  static Matrix34d of_jacobian(const Eigen::Vector3d& g, double rho) {
    Matrix34d J = InverseDepth::of_jacobian(g, rho);
    J(2, 3) = 1.0 / rho;
    return J;
  }
  static bool exists(const Eigen::Vector3d& g, double rho) { return !is_vertical(g) && rho > 0.0; }
};

static_assert(PointParametrisation<LogInverseDepth>);

}  // namespace slammot
