#include "smoothers/ceres/manifolds.h"

#include "smoothers/graph/residuals.h"

namespace slammot {
namespace {

using Block3 = Eigen::Map<const Eigen::Vector3d>;
template <int Rows, int Cols>
using OfCeres = Eigen::Matrix<double, Rows, Cols, Eigen::RowMajor>;

}  // namespace

Eigen::Matrix<double, 4, 3> tangent_basis(const double* q) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  Eigen::Matrix<double, 4, 3> A;
  A << w, -z, y, z, w, -x, -y, x, w, -x, -y, -z;
  return A;
}

bool OrientationManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  Eigen::Map<Eigen::Vector4d>(x_plus_delta, 4) =
      plus(true, Eigen::Map<const Eigen::Vector4d>(x), Block3(delta));
  return true;
}

bool OrientationManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Eigen::Vector3d>(y_minus_x, 3) =
      minus(true, Eigen::Map<const Eigen::Vector4d>(y), Eigen::Map<const Eigen::Vector4d>(x));
  return true;
}

bool OrientationManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<OfCeres<4, 3>>(jacobian, 4, 3) = 0.5 * tangent_basis(x);
  return true;
}

bool OrientationManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<OfCeres<3, 4>>(jacobian, 3, 4) = 2.0 * tangent_basis(x).transpose();
  return true;
}

bool FarPointManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  Eigen::Map<Eigen::Vector3d>(x_plus_delta, 3) =
      Block3(x) + limited_step(point_, Block3(x), Block3(delta), farthest_).step;
  return true;
}

bool FarPointManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Eigen::Vector3d>(y_minus_x, 3) = Block3(y) - Block3(x);
  return true;
}

bool FarPointManifold::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<OfCeres<3, 3>>(jacobian, 3, 3).setIdentity();
  return true;
}

bool FarPointManifold::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<OfCeres<3, 3>>(jacobian, 3, 3).setIdentity();
  return true;
}

}  // namespace slammot
