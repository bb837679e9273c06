// How Ceres steps on what is not Euclidean.
#pragma once

#include <ceres/manifold.h>

#include "smoothers/graph/graph.h"

namespace slammot {

// The imaginary directions at q (x, y, z, w): d(q Exp(d))/dd = A/2, with orthonormal columns.
Eigen::Matrix<double, 4, 3> tangent_basis(const double* q);

// q (x, y, z, w) with the error of camera_state.h: q Exp(d), d in the camera's frame.
class OrientationManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 4; }
  int TangentSize() const override { return 3; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

// y of a point that lacks infinity: steps are limited (residuals.h). Small ones are not changed,
// but for those that lead beyond `farthest`.
class FarPointManifold final : public ceres::Manifold {
 public:
  FarPointManifold(const PointFunctions& point, double farthest)
      : point_(point), farthest_(farthest) {}
  int AmbientSize() const override { return 3; }
  int TangentSize() const override { return 3; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  const PointFunctions& point_;
  double farthest_;
};

}  // namespace slammot
