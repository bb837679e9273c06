// The moving camera (thesis 2.2): position r (W) [m], orientation R = R_WC, velocity v (W) [m/s],
// angular velocity omega (C) [rad/s].
//
// The thesis keeps a 4-vector quaternion and renormalises it; here the quaternion is always of unit
// length and the error state is [dr (W), dtheta (C, right), dv (W), domega (C)], 12 numbers.
#pragma once

#include "models/so3.h"

namespace slammot {

inline constexpr int kCameraDim = 12;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector12d = Eigen::Matrix<double, kCameraDim, 1>;
using Matrix12d = Eigen::Matrix<double, kCameraDim, kCameraDim>;

// Where each part of the error state begins.
enum CameraOffset : int { kPosition = 0, kRotation = 3, kVelocity = 6, kAngularVelocity = 9 };

template <typename T>
struct CameraStateT {
  Vector3<T> position = Vector3<T>::Zero();
  Eigen::Quaternion<T> orientation = Eigen::Quaternion<T>::Identity();
  Vector3<T> velocity = Vector3<T>::Zero();
  Vector3<T> angular_velocity = Vector3<T>::Zero();
};
using CameraState = CameraStateT<double>;

// x [+] d: applies an error to a state.
template <typename T>
CameraStateT<T> boxplus(const CameraStateT<T>& x, const Eigen::Matrix<T, kCameraDim, 1>& d) {
  const Vector3<T> dtheta = d.template segment<3>(kRotation);
  CameraStateT<T> y;
  y.position = x.position + d.template segment<3>(kPosition);
  y.orientation = (x.orientation * exp_so3(dtheta)).normalized();
  y.velocity = x.velocity + d.template segment<3>(kVelocity);
  y.angular_velocity = x.angular_velocity + d.template segment<3>(kAngularVelocity);
  return y;
}

// y [-] x: the error d with y = x [+] d.
template <typename T>
Eigen::Matrix<T, kCameraDim, 1> boxminus(const CameraStateT<T>& y, const CameraStateT<T>& x) {
  Eigen::Matrix<T, kCameraDim, 1> d;
  const Eigen::Quaternion<T> relative = x.orientation.conjugate() * y.orientation;
  d << y.position - x.position, log_so3(relative), y.velocity - x.velocity,
      y.angular_velocity - x.angular_velocity;
  return d;
}

}  // namespace slammot
