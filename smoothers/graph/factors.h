// The factors of the graph as Ceres cost functions. Each wraps the function of models/ that the
// filter calls, value and Jacobian, and adds only its weight.
//
// Blocks: camera position (3) and motion (10, camera_manifold.h), anchor (3), y = (theta, phi, rho)
// (3), w (3). Jacobians are computed in error states and lifted to the ambient space of the blocks
// by the manifold's MinusJacobian, so that Ceres' PlusJacobian gives them back exactly.
#pragma once

#include <ceres/cost_function.h>

#include <memory>

#include "models/camera.h"
#include "models/camera_motion.h"
#include "models/landmarks/landmark.h"

namespace slammot {

using Cost = std::unique_ptr<ceres::CostFunction>;

// (x [-] x0) / sigma, 12 residuals. Blocks: position, motion.
Cost initial_camera_cost(const InitialCamera& initial);

// L^-1 (x1 [-] f(x0)), L L' = Q: 12 residuals. Blocks: position0, motion0, position1, motion1.
// Throws std::invalid_argument when Q is singular (discretisation impulse).
Cost camera_motion_cost(const Matrix12d& Q, double dt);

// (h - z) / sigma, 2 residuals; fails when the landmark is behind the camera. Blocks: position,
// motion, anchor, y.
Cost pixel_cost(const Camera& camera, const Eigen::Vector2d& pixel, double sigma);

// The same in the frame where the landmark was initialised: its anchor is the camera's position.
// Blocks: motion, y.
Cost first_pixel_cost(const Camera& camera, const Eigen::Vector2d& pixel, double sigma);

// (rho - rho0) / sigma_rho. Block: y.
Cost inverse_depth_prior_cost(const LandmarkPrior& prior);

// (rho - m) / sigma_rho, where the mean m of the scene's inverse depths is a variable of size 1.
// Blocks: y, m.
Cost shared_inverse_depth_cost(const LandmarkPrior& prior);

// (m - rho0) / mean_sigma. Block: m.
Cost scene_prior_cost(const LandmarkPrior& prior);

// w / sigma, number by number. Block: w.
Cost motion_prior_cost(const MotionVector& sigmas);

// n, `dim` residuals: the unit noise of a landmark's chain. Block: n.
Cost noise_prior_cost(int dim);

// (a + G/rho - X) / sigma, 3 residuals. Blocks: anchor, y.
Cost known_landmark_cost(const KnownLandmark& known);

}  // namespace slammot
