// The residuals as Ceres cost functions, for the batch, for `window.solver: ceres`, and as the
// judge of our own solver. Blocks: camera position (3), orientation (4, OrientationManifold) and
// rates (6), anchor (3), y (3), w, noises.
//
// Jacobians are computed in error states and lifted to the quaternion by the manifold's
// MinusJacobian, so that Ceres' PlusJacobian gives them back exactly.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/manifold.h>

#include <memory>

#include "smoothers/graph/graph.h"

namespace slammot {

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

using Cost = std::unique_ptr<ceres::CostFunction>;

// Blocks: position, orientation, rates; of both cameras.
Cost initial_camera_cost(const InitialCamera& initial);
Cost camera_motion_cost(const Matrix12d& weight, double dt);

// Blocks: position, orientation, anchor, y; seen from the anchor itself orientation, y. Fails when
// the landmark is behind the camera. The models must outlive it.
Cost pixel_cost(const GraphModels& models, const MeasuredPixel& z);

// Seen `depth` >= 1 steps after the base. Blocks: position, orientation, anchor, y, w, then `depth`
// noises. The chain must outlive it.
Cost chain_pixel_cost(const GraphModels& models, const MeasuredPixel& z,
                      const std::vector<ChainStep>& chain, int depth);

// Block y; of a shared depth y and the scene's mean; of a known landmark anchor and y.
Cost birth_cost(const PointFunctions& point, const BirthPrior& birth);

// (x - mean) / sigma, number by number. One block.
Cost gaussian_cost(const Eigen::VectorXd& mean, const Eigen::VectorXd& sigmas);

// The marginal prior over its blocks' variables, in their order.
Cost marginal_prior_cost(const MarginalPrior& prior);

}  // namespace slammot
