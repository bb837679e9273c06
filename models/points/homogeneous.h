// A homogeneous point (m, s) of unit length, x_W = a + m/s, as Triggs et al. 2000 advise for
// distant points, in three numbers: the stereographic projection of the unit sphere in R^4 from (0,
// -1),
//
//   y = m / (1 + s),   |y| = sqrt(1 + rho^2) - rho,   rho = (1 - |y|^2) / (2 |y|)
//
// as modified Rodrigues parameters are one of unit quaternions (Schaub & Junkins 1996). |y| = 1 is
// infinity, behind it |y| > 1; no direction is singular. With a metre as the unit, y is nearly
// linear in the position of points much nearer than that, and in rho of those much farther.
#pragma once

#include "models/points/point.h"

namespace slammot {

struct Homogeneous {
  static constexpr std::string_view kName = "homogeneous";
  static constexpr std::string_view kDescription =
      "unit homogeneous point, stereographic coordinates";
  static constexpr bool kLinearDepth = false;

  template <typename T>
  static Vector3<T> direction(const Vector3<T>& y) {
    return y / y.norm();
  }
  static Eigen::Matrix3d direction_jacobian(const Eigen::Vector3d& y) { return unit_jacobian(y); }
  template <typename T>
  static T inverse_depth(const Vector3<T>& y) {
    const T t = y.norm();
    return (T(1.0) - t) * (T(1.0) + t) / (T(2.0) * t);
  }
  static Eigen::RowVector3d inverse_depth_jacobian(const Eigen::Vector3d& y) {
    const double t = y.norm();
    return -(1.0 + t * t) / (2.0 * t * t * t) * y.transpose();
  }

  template <typename T>
  static Vector3<T> of(const Vector3<T>& g, const T& rho, const Vector3<T>& /*near*/) {
    return g * T(radius(rho) / g.norm());
  }
  static Matrix34d of_jacobian(const Eigen::Vector3d& g, double rho) {
    const double t = radius(rho);
    Matrix34d J;
    J << t * unit_jacobian(g), -t / std::hypot(1.0, rho) * g / g.norm();
    return J;
  }
  static bool exists(const Eigen::Vector3d& /*g*/, double /*rho*/) { return true; }

 private:
  // |y|, without a difference of nearly equal numbers where rho is large.
  template <typename T>
  static T radius(const T& rho) {
    using std::sqrt;
    return T(1.0) / (rho + sqrt(T(1.0) + rho * rho));
  }
};

static_assert(PointParametrisation<Homogeneous>);

}  // namespace slammot
