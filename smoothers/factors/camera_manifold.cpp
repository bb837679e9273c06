#include "smoothers/factors/camera_manifold.h"

namespace slammot {

namespace {

using Matrix43d = Eigen::Matrix<double, 4, 3>;
using PlusMatrix = Eigen::Matrix<double, kMotionSize, kMotionDim, Eigen::RowMajor>;
using MinusMatrix = Eigen::Matrix<double, kMotionDim, kMotionSize, Eigen::RowMajor>;

// The imaginary directions at q: d(q Exp(d))/dd = A/2, with orthonormal columns.
Matrix43d tangent_basis(const double* q) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  Matrix43d A;
  A << w, -z, y, z, w, -x, -y, x, w, -x, -y, -z;
  return A;
}

}  // namespace

CameraState camera_from_blocks(const double* position, const double* motion) {
  CameraState x;
  x.position = Eigen::Map<const Eigen::Vector3d>(position);
  x.orientation = Eigen::Map<const Eigen::Quaterniond>(motion);
  x.velocity = Eigen::Map<const Eigen::Vector3d>(motion + 4);
  x.angular_velocity = Eigen::Map<const Eigen::Vector3d>(motion + 7);
  return x;
}

void camera_to_blocks(const CameraState& state, double* position, double* motion) {
  Eigen::Map<Eigen::Vector3d>(position, 3) = state.position;
  Eigen::Map<Eigen::Vector4d>(motion, 4) = state.orientation.coeffs();
  Eigen::Map<Eigen::Vector3d>(motion + 4, 3) = state.velocity;
  Eigen::Map<Eigen::Vector3d>(motion + 7, 3) = state.angular_velocity;
}

bool MotionManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const double origin[3] = {0.0, 0.0, 0.0};
  Vector12d d;
  d << Eigen::Vector3d::Zero(), Eigen::Map<const Eigen::Matrix<double, kMotionDim, 1>>(delta);
  double position[3];
  camera_to_blocks(boxplus(camera_from_blocks(origin, x), d), position, x_plus_delta);
  return true;
}

bool MotionManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const double origin[3] = {0.0, 0.0, 0.0};
  const Vector12d d = boxminus(camera_from_blocks(origin, y), camera_from_blocks(origin, x));
  Eigen::Map<Eigen::Matrix<double, kMotionDim, 1>>(y_minus_x, kMotionDim) = d.tail<kMotionDim>();
  return true;
}

bool MotionManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<PlusMatrix> J(jacobian);
  J.setZero();
  J.topLeftCorner<4, 3>() = 0.5 * tangent_basis(x);
  J.bottomRightCorner<6, 6>().setIdentity();
  return true;
}

bool MotionManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<MinusMatrix> J(jacobian);
  J.setZero();
  J.topLeftCorner<3, 4>() = 2.0 * tangent_basis(x).transpose();
  J.bottomRightCorner<6, 6>().setIdentity();
  return true;
}

}  // namespace slammot
