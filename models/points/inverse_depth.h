// Inverse depth (thesis 2.1.2 without its velocity; Civera, Davison & Montiel 2008):
// y = (theta, phi, rho) [rad, rad, 1/m],
//
//   G(theta, phi) = (cos phi sin theta, -sin phi, cos phi cos theta) (2.4)
//
// Not defined along the y axis (phi = +-pi/2).
#pragma once

#include "models/points/point.h"

namespace slammot {

// G(theta, phi), (2.4).
template <typename T>
Vector3<T> direction(const T& theta, const T& phi) {
  using std::cos;
  using std::sin;
  return Vector3<T>(cos(phi) * sin(theta), -sin(phi), cos(phi) * cos(theta));
}

// dG / d(theta, phi).
inline Matrix32d direction_jacobian(double theta, double phi) {
  const double st = std::sin(theta), ct = std::cos(theta);
  const double sp = std::sin(phi), cp = std::cos(phi);
  Matrix32d J;
  J << cp * ct, -sp * st, 0.0, -cp, -cp * st, -sp * ct;
  return J;
}

// (theta, phi) of a vector of any length. Theta is the one nearest to `near_theta`, so that an
// angle followed through time never jumps by a full turn.
template <typename T>
Vector2<T> angles(const Vector3<T>& g, const T& near_theta) {
  using std::atan2;
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T s = sin(near_theta), c = cos(near_theta);
  const T turn = atan2(T(g.x() * c - g.z() * s), T(g.x() * s + g.z() * c));
  return Vector2<T>(near_theta + turn, atan2(T(-g.y()), sqrt(T(g.x() * g.x() + g.z() * g.z()))));
}

// d(theta, phi) / dg.
inline Matrix23d angles_jacobian(const Eigen::Vector3d& g) {
  const double c2 = g.x() * g.x() + g.z() * g.z();
  const double c = std::sqrt(c2);
  const double n2 = c2 + g.y() * g.y();
  Matrix23d J;
  J << g.z() / c2, 0.0, -g.x() / c2, g.y() * g.x() / (c * n2), -c / n2, g.y() * g.z() / (c * n2);
  return J;
}

inline bool is_vertical(const Eigen::Vector3d& g) {
  constexpr double kVertical = 1e-12;  // squared sine of the angle to the y axis
  return g.x() * g.x() + g.z() * g.z() < kVertical * g.squaredNorm();
}

struct InverseDepth {
  static constexpr std::string_view kName = "inverse_depth";
  static constexpr std::string_view kDescription = "(theta, phi, rho), Civera et al. 2008";
  static constexpr bool kLinearDepth = true;

  template <typename T>
  static Vector3<T> direction(const Vector3<T>& y) {
    return slammot::direction(T(y.x()), T(y.y()));
  }
  static Eigen::Matrix3d direction_jacobian(const Eigen::Vector3d& y) {
    Eigen::Matrix3d J;
    J << slammot::direction_jacobian(y.x(), y.y()), Eigen::Vector3d::Zero();
    return J;
  }
  template <typename T>
  static T inverse_depth(const Vector3<T>& y) {
    return y.z();
  }
  static Eigen::RowVector3d inverse_depth_jacobian(const Eigen::Vector3d& /*y*/) {
    return Eigen::RowVector3d::UnitZ();
  }

  template <typename T>
  static Vector3<T> of(const Vector3<T>& g, const T& rho, const Vector3<T>& near) {
    Vector3<T> y;
    y << angles(g, T(near.x())), rho;
    return y;
  }
  static Matrix34d of_jacobian(const Eigen::Vector3d& g, double /*rho*/) {
    Matrix34d J = Matrix34d::Zero();
    J.topLeftCorner<2, 3>() = angles_jacobian(g);
    J(2, 3) = 1.0;
    return J;
  }
  static bool exists(const Eigen::Vector3d& g, double /*rho*/) { return !is_vertical(g); }
};

static_assert(PointParametrisation<InverseDepth>);

}  // namespace slammot
