// A free landmark through the frames of a window: one base state x_0 = (y, w) at the oldest of
// them, and from each frame to the next the landmark model with its noise as a variable of its own,
//
//   x_j = f(x_{j-1}) + G_j n_j,   n_j ~ N(0, I),   Q_j = G_j G_j'.
//
// The model is that of one state per frame joined by factors of covariance Q, but without stiff
// constraints. When depth and velocity of the base change, the whole chain follows exactly; with a
// state per frame, a step of Gauss-Newton would violate the motion factors. Q may be singular.
//
// y = (theta, phi, rho) and w are in the coordinates of the landmark model
// (models/landmarks/landmark_models.h).
#pragma once

#include <ceres/cost_function.h>

#include <memory>

#include "models/camera.h"
#include "models/landmarks/landmark_models.h"

namespace slammot {

struct ChainStep {
  double dt = 0.0;  // [s]
  LandmarkMatrix G;
};

// The steps of one landmark, oldest first. Its factors share it.
struct Chain {
  const LandmarkFunctions* landmark = nullptr;
  std::vector<ChainStep> steps;
};

struct ChainState {
  LandmarkVector x;
  Eigen::MatrixXd J;  // dim x dim (1 + n): with respect to the base and the noises
};

// The state after noises.size() steps from the base, and its Jacobian.
ChainState propagate(const Chain& chain, const LandmarkVector& base,
                     const std::vector<LandmarkVector>& noises);

// The states x_0 .. x_n of the chain.
std::vector<LandmarkVector> states(const Chain& chain, const LandmarkVector& base,
                                   const std::vector<LandmarkVector>& noises);

// Takes G of every step of the chain along these states, and returns the noises of least norm that
// lead through them. G depends on the depth, which a smoother goes on correcting: with the old
// noises and a new G the landmark would jump.
std::vector<LandmarkVector> lead_through(Chain& chain, const std::vector<LandmarkVector>& states,
                                         const LandmarkPrior& prior);

// The smoothers solve, refresh the noises (lead_through) and solve again until no noise changes by
// more than this [sigma]; the window so often at most.
inline constexpr double kNegligibleNoise = 1e-7;
inline constexpr int kMaxRefreshes = 20;

// The state y of a static landmark, with J = I.
ChainState static_state(const Eigen::Vector3d& y);

// (h - z) / sigma of a pixel seen `depth` >= 1 steps after the base; fails when the landmark is
// behind the camera. Blocks: position, motion, anchor, y, w, then `depth` noises.
class ChainPixelCost final : public ceres::CostFunction {
 public:
  ChainPixelCost(const Camera& camera, const Eigen::Vector2d& pixel, double sigma,
                 std::shared_ptr<const Chain> chain, int depth);

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  Camera camera_;
  Eigen::Vector2d pixel_;
  double sigma_;
  std::shared_ptr<const Chain> chain_;
  int depth_;
};

}  // namespace slammot
