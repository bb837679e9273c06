// The camera as Ceres parameter blocks: its position in the world (3, Euclidean), which stays as
// the anchor of landmarks first seen there; and its motion (q, v, omega), 10 numbers with 9 degrees
// of freedom [dtheta (C, right), dv (W), domega (C)], in the error convention of camera_state.h.
#pragma once

#include <ceres/manifold.h>

#include "models/camera_state.h"

namespace slammot {

inline constexpr int kMotionSize = 10;
inline constexpr int kMotionDim = 9;

// q is stored as Eigen stores it: x, y, z, w.
CameraState camera_from_blocks(const double* position, const double* motion);
void camera_to_blocks(const CameraState& state, double* position, double* motion);

class MotionManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kMotionSize; }
  int TangentSize() const override { return kMotionDim; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

}  // namespace slammot
