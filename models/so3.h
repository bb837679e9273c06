// Rotations as exponentials: hat, Exp, Log and the right Jacobian of SO(3).
//
// Convention: R = R^ Exp(dtheta), the perturbation stands on the right, in the body (camera) frame.
// Source: J. Sola et al., "A micro Lie theory for state estimation in robotics", eqs. (132) to
// (146). Every function is a template over its scalar, so that Ceres' Jets can pass through it;
// near zero the series replaces the quotient, so that neither value nor derivative is ever 0/0.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace slammot {

template <typename T>
using Vector2 = Eigen::Matrix<T, 2, 1>;
template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

// The cross product as a matrix: hat(a) b = a x b.
template <typename T>
Matrix3<T> hat(const Vector3<T>& a) {
  Matrix3<T> m;
  m << T(0), -a.z(), a.y(), a.z(), T(0), -a.x(), -a.y(), a.x(), T(0);
  return m;
}

// Below this squared angle the series to fourth order is exact to double precision.
inline constexpr double kSmallSquaredAngle = 1e-6;

// Unit quaternion of the rotation by the vector `theta` [rad].
template <typename T>
Eigen::Quaternion<T> exp_so3(const Vector3<T>& theta) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T squared = theta.squaredNorm();
  if (squared < T(kSmallSquaredAngle)) {
    const T scale = T(0.5) - squared / T(48.0) + squared * squared / T(3840.0);
    const T real = T(1.0) - squared / T(8.0) + squared * squared / T(384.0);
    return Eigen::Quaternion<T>(real, scale * theta.x(), scale * theta.y(), scale * theta.z());
  }
  const T angle = sqrt(squared);
  const T scale = sin(angle / T(2.0)) / angle;
  return Eigen::Quaternion<T>(cos(angle / T(2.0)), scale * theta.x(), scale * theta.y(),
                              scale * theta.z());
}

// Rotation vector [rad] of a unit quaternion, of length at most pi (q and -q give the same vector).
template <typename T>
Vector3<T> log_so3(const Eigen::Quaternion<T>& q) {
  using std::atan2;
  using std::sqrt;
  const T sign = q.w() < T(0) ? T(-1) : T(1);
  const Vector3<T> im = sign * q.vec();
  const T re = sign * q.w();
  const T squared = im.squaredNorm();
  if (squared < T(kSmallSquaredAngle)) {
    const T ratio = squared / (re * re);
    return (T(2.0) / re) * (T(1.0) - ratio / T(3.0) + ratio * ratio / T(5.0)) * im;
  }
  const T norm = sqrt(squared);
  return (T(2.0) * atan2(norm, re) / norm) * im;
}

// J_r with Exp(theta + d) = Exp(theta) Exp(J_r d) to first order.
inline Eigen::Matrix3d right_jacobian_so3(const Eigen::Vector3d& theta) {
  const double squared = theta.squaredNorm();
  double a = 0.5 - squared / 24.0 + squared * squared / 720.0;          // (1 - cos t) / t^2
  double b = 1.0 / 6.0 - squared / 120.0 + squared * squared / 5040.0;  // (t - sin t) / t^3
  if (squared >= kSmallSquaredAngle) {
    const double t = std::sqrt(squared);
    const double half_sine = std::sin(t / 2.0);
    a = 2.0 * half_sine * half_sine / squared;
    b = (t - std::sin(t)) / (squared * t);
  }
  const Eigen::Matrix3d w = hat(theta);
  return Eigen::Matrix3d::Identity() - a * w + b * w * w;
}

// The inverse of right_jacobian_so3: Log(Exp(theta) Exp(d)) = theta + J_r^-1 d to first order.
inline Eigen::Matrix3d inverse_right_jacobian_so3(const Eigen::Vector3d& theta) {
  const double squared = theta.squaredNorm();
  double c = 1.0 / 12.0 + squared / 720.0 + squared * squared / 30240.0;
  if (squared >= kSmallSquaredAngle) {
    const double half = std::sqrt(squared) / 2.0;
    c = (1.0 - half * std::cos(half) / std::sin(half)) / squared;
  }
  const Eigen::Matrix3d w = hat(theta);
  return Eigen::Matrix3d::Identity() + 0.5 * w + c * w * w;
}

}  // namespace slammot
