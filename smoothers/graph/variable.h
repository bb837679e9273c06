// A variable of the graph, and the arithmetic of its tangent space.
#pragma once

#include <ceres/manifold.h>

#include <Eigen/Core>
#include <optional>

namespace slammot {

inline constexpr int kMaxBlock = 12;  // residuals of a factor, numbers of a variable
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxBlock, 1>;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxBlock, kMaxBlock>;

using VariableId = int;

struct Variable {
  VariableId id = 0;
  SmallVector value;
  const ceres::Manifold* manifold = nullptr;  // null: Euclidean
  int owner = -1;  // the track whose private state it is, or -1 when shared
  std::optional<SmallVector> linearisation_point;  // set: Jacobians are taken there, not at value

  // Scratch of Graph::cost() and Graph::retract(): the value to be tried; the correction that was
  // made, and the transport that goes with it.
  SmallVector candidate, correction;
  std::optional<Eigen::Matrix3d> turn;

  int dim() const { return manifold ? manifold->TangentSize() : static_cast<int>(value.size()); }
  const SmallVector& point() const { return linearisation_point ? *linearisation_point : value; }
};

// x [+] d and y [-] x: x and y as stored, d in the tangent space at x.
SmallVector plus(const ceres::Manifold* manifold, const SmallVector& x, const SmallVector& d);
SmallVector minus(const ceres::Manifold* manifold, const SmallVector& y, const SmallVector& x);

// d(x [-] x0)/dx at the variable's value x, dim x dim: the identity for a Euclidean variable. A
// manifold has its rotation in the first three coordinates (camera_manifold.h), where this is the
// inverse right Jacobian of SO(3).
SmallMatrix transport(const Variable& x, const SmallVector& x0);

}  // namespace slammot
