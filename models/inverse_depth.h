// Inverse depth (thesis 2.1.2 without its velocity; Civera, Davison & Montiel 2008): a point seen
// from the anchor a (W), where the camera was when the point was first seen, in the direction
// (theta, phi) at the inverse distance rho:
//
//   x_W = a + G(theta, phi) / rho,   G = (cos phi sin theta, -sin phi, cos phi cos theta) (2.4)
//
// A landmark that does not move is y = (theta, phi, rho) [rad, rad, 1/m]. Every landmark model
// starts with these three, so that it collapses to static by losing the rest. The anchor is kept
// apart, because all landmarks born in one frame share it exactly.
#pragma once

#include "models/camera_state.h"

namespace slammot {

using Matrix23d = Eigen::Matrix<double, 2, 3>;
using Matrix32d = Eigen::Matrix<double, 3, 2>;

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

// d(theta, phi) / dg. Not defined along the y axis (phi = +-pi/2).
inline Matrix23d angles_jacobian(const Eigen::Vector3d& g) {
  const double c2 = g.x() * g.x() + g.z() * g.z();
  const double c = std::sqrt(c2);
  const double n2 = c2 + g.y() * g.y();
  Matrix23d J;
  J << g.z() / c2, 0.0, -g.x() / c2, g.y() * g.x() / (c * n2), -c / n2, g.y() * g.z() / (c * n2);
  return J;
}

// The ray from a camera at r to the landmark, in W, scaled by rho (Montiel et al. 2006): regular at
// rho = 0, where it is the direction alone.
template <typename T>
Vector3<T> ray_world(const Vector3<T>& r, const Vector3<T>& anchor, const Vector3<T>& y) {
  return y.z() * (anchor - r) + direction(T(y.x()), T(y.y()));
}

// d ray_world / dy; with respect to the anchor it is rho I, to r it is -rho I.
inline Eigen::Matrix3d ray_jacobian(const Eigen::Vector3d& r, const Eigen::Vector3d& anchor,
                                    const Eigen::Vector3d& y) {
  Eigen::Matrix3d J;
  J << direction_jacobian(y.x(), y.y()), anchor - r;
  return J;
}

// x_W, (2.4). Infinite at rho = 0.
inline Eigen::Vector3d position_world(const Eigen::Vector3d& anchor, const Eigen::Vector3d& y) {
  return anchor + direction(y.x(), y.y()) / y.z();
}

// d position_world / dy; with respect to the anchor it is the identity.
inline Eigen::Matrix3d position_jacobian(const Eigen::Vector3d& y) {
  Eigen::Matrix3d J;
  J << direction_jacobian(y.x(), y.y()) / y.z(), -direction(y.x(), y.y()) / (y.z() * y.z());
  return J;
}

// y of a point given by its offset d = x_W - a from the anchor.
template <typename T>
Vector3<T> inverse_depth_of(const Vector3<T>& d) {
  using std::sqrt;
  Vector3<T> y;
  y << angles(d, T(0.0)), T(1.0) / sqrt(d.squaredNorm());
  return y;
}

// d inverse_depth_of / dd.
inline Eigen::Matrix3d inverse_depth_jacobian(const Eigen::Vector3d& d) {
  const double n = d.norm();
  Eigen::Matrix3d J;
  J << angles_jacobian(d), -d.transpose() / (n * n * n);
  return J;
}

}  // namespace slammot
