// The residuals as Ceres cost functions, for the batch, for `window.solver: ceres`, and as the
// judge of our own solver. Blocks: camera position (3), orientation (4, manifolds.h) and
// rates (6), anchor (3), y (3), w, noises.
//
// Jacobians are computed in error states and lifted to the quaternion by the manifold's
// MinusJacobian, so that Ceres' PlusJacobian gives them back exactly.
#pragma once

#include <ceres/cost_function.h>

#include <memory>

#include "smoothers/graph/graph.h"

namespace slammot {

using Cost = std::unique_ptr<ceres::CostFunction>;

// Blocks: position, orientation, rates; of both cameras.
Cost initial_camera_cost(const InitialCamera& initial);
// With `speed` > 0, which is u(v^), in units of the speed (noise_scale.h).
Cost camera_motion_cost(const Matrix12d& weight, double dt, double speed = 0.0);

// Blocks: position, orientation, anchor, y; seen from the anchor itself orientation, y. Fails when
// the landmark is behind the camera. The models must outlive it.
Cost pixel_cost(const GraphModels& models, const MeasuredPixel& z);

// Seen `depth` >= 1 steps after the base. Blocks: position, orientation, anchor, y, w, then `depth`
// noises. Models and chain must outlive it.
Cost chain_pixel_cost(const GraphModels& models, const MeasuredPixel& z,
                      const std::vector<ChainStep>& chain, int depth);

// Block y; of a shared depth y and the scene's mean; of a known landmark anchor and y.
Cost birth_cost(const PointFunctions& point, const BirthPrior& birth);

// Of a motion in units of its landmark's distance (chain_step.h). Blocks: y, w. The models must
// outlive it.
Cost motion_prior_cost(const GraphModels& models, const MotionPrior& prior);

// (x - mean) / sigma, number by number. One block.
Cost gaussian_cost(const Eigen::VectorXd& mean, const Eigen::VectorXd& sigmas);

// The marginal prior over its blocks' variables, in their order.
Cost marginal_prior_cost(const MarginalPrior& prior);

}  // namespace slammot
