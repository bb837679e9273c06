#include "models/camera_motion.h"

namespace slammot {

Matrix12d predict_jacobian(const CameraState& x, double dt) {
  const Eigen::Vector3d turn = x.angular_velocity * dt;
  Matrix12d F = Matrix12d::Identity();
  F.block<3, 3>(kPosition, kVelocity).diagonal().setConstant(dt);
  F.block<3, 3>(kRotation, kRotation) = exp_so3(turn).conjugate().toRotationMatrix();
  F.block<3, 3>(kRotation, kAngularVelocity) = dt * right_jacobian_so3(turn);
  return F;
}

Eigen::Matrix2d white_noise_pattern(double dt) {
  Eigen::Matrix2d pattern;
  pattern << dt * dt / 3.0, dt / 2.0, dt / 2.0, 1.0;
  return pattern * dt * dt;
}

namespace {

Matrix12d white_noise(const MotionNoise& noise, double dt) {
  const Eigen::Matrix2d pattern = white_noise_pattern(dt);
  const double linear = noise.acceleration * noise.acceleration;
  const double angular = noise.angular_acceleration * noise.angular_acceleration;
  Matrix12d Q = Matrix12d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        Q(6 * i + axis, 6 * j + axis) = linear * pattern(i, j);
        Q(6 * i + 3 + axis, 6 * j + 3 + axis) = angular * pattern(i, j);
      }
    }
  }
  return Q;
}

// Q = G Sigma G' with (V, Omega) = (n, alpha) dt added to (v, omega) before the step.
Matrix12d impulse_noise(const MotionNoise& noise, const CameraState& x, double dt) {
  const Matrix12d F = predict_jacobian(x, dt);
  Eigen::Matrix<double, kCameraDim, 6> G = F.rightCols<6>() * dt;
  G.leftCols<3>() *= noise.acceleration;
  G.rightCols<3>() *= noise.angular_acceleration;
  return G * G.transpose();
}

}  // namespace

Matrix12d camera_noise(const MotionNoise& noise, const CameraState& x, double dt) {
  return noise.discretisation == NoiseDiscretisation::kImpulse ? impulse_noise(noise, x, dt)
                                                               : white_noise(noise, dt);
}

}  // namespace slammot
