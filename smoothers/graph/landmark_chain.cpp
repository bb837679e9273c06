#include "smoothers/graph/landmark_chain.h"

#include <Eigen/QR>

#include "models/observation.h"
#include "smoothers/graph/camera_manifold.h"
#include "smoothers/graph/cost_tools.h"

namespace slammot {

ChainState propagate(const Chain& chain, const LandmarkVector& base,
                     const std::vector<LandmarkVector>& noises) {
  const auto n = static_cast<Eigen::Index>(noises.size());
  const Eigen::Index dim = base.size();
  ChainState state{base, Eigen::MatrixXd::Zero(dim, dim * (1 + n))};
  state.J.leftCols(dim).setIdentity();
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto k = static_cast<std::size_t>(j);
    const ChainStep& step = chain.steps[k];
    const LandmarkMatrix F = chain.landmark->predict_jacobian(state.x, step.dt);
    state.x = chain.landmark->predict(state.x, step.dt) + step.G * noises[k];
    state.J.leftCols(dim * (j + 1)) = (F * state.J.leftCols(dim * (j + 1))).eval();
    state.J.middleCols(dim * (j + 1), dim) = step.G;
  }
  return state;
}

std::vector<LandmarkVector> states(const Chain& chain, const LandmarkVector& base,
                                   const std::vector<LandmarkVector>& noises) {
  std::vector<LandmarkVector> x{base};
  for (std::size_t i = 0; i < noises.size(); ++i) {
    const ChainStep& step = chain.steps[i];
    x.push_back(chain.landmark->predict(x.back(), step.dt) + step.G * noises[i]);
  }
  return x;
}

std::vector<LandmarkVector> lead_through(Chain& chain, const std::vector<LandmarkVector>& states,
                                         const LandmarkPrior& prior) {
  std::vector<LandmarkVector> noises;
  LandmarkVector x = states.front();
  for (std::size_t i = 0; i + 1 < states.size(); ++i) {
    ChainStep& step = chain.steps[i];
    x = chain.landmark->predict(x, step.dt);
    step.G = chain.landmark->noise_root(x, prior, step.dt);
    // The least noise that does it best: G is singular at infinity.
    noises.push_back(step.G.completeOrthogonalDecomposition().solve(states[i + 1] - x));
    x += step.G * noises.back();
  }
  return noises;
}

ChainState static_state(const Eigen::Vector3d& y) { return {y, Eigen::Matrix3d::Identity()}; }

ChainPixelCost::ChainPixelCost(const Camera& camera, const Eigen::Vector2d& pixel, double sigma,
                               std::shared_ptr<const Chain> chain, int depth)
    : camera_(camera), pixel_(pixel), sigma_(sigma), chain_(std::move(chain)), depth_(depth) {
  set_num_residuals(2);
  const LandmarkFunctions& landmark = *chain_->landmark;
  *mutable_parameter_block_sizes() = {3, kMotionSize, 3, 3, landmark.motion};
  for (int i = 0; i < depth; ++i) mutable_parameter_block_sizes()->push_back(landmark.dim());
}

// The Jacobians are carried back along the chain, from the pixel to the base: two rows through each
// step, where carrying the state's Jacobian forward would take six for each noise before.
bool ChainPixelCost::Evaluate(double const* const* x, double* residuals, double** jacobians) const {
  using Block = Eigen::Map<const Eigen::Vector3d>;
  const auto depth = static_cast<std::size_t>(depth_);
  std::vector<LandmarkVector> states(depth + 1);
  const int dim = chain_->landmark->dim();
  states[0] = landmark_state(Block(x[3]), Eigen::Map<const Eigen::VectorXd>(x[4], dim - 3));
  for (std::size_t i = 0; i < depth; ++i) {
    const ChainStep& step = chain_->steps[i];
    states[i + 1] = chain_->landmark->predict(states[i], step.dt) +
                    step.G * Eigen::Map<const Eigen::VectorXd>(x[5 + i], dim);
  }
  const CameraState c = camera_from_blocks(x[0], x[1]);
  const auto h = observe(camera_, c.position, c.orientation, Block(x[2]),
                         Eigen::Vector3d(states.back().head<3>()));
  if (!h) return false;
  Eigen::Map<Eigen::Vector2d>(residuals, 2) = (h->pixel - pixel_) / sigma_;
  if (!jacobians) return true;
  Eigen::Matrix<double, 2, kMotionDim> J_motion = Eigen::Matrix<double, 2, kMotionDim>::Zero();
  J_motion.leftCols<3>() = h->J_pose.rightCols<3>() / sigma_;
  write<2, 3>(jacobians, 0, h->J_pose.leftCols<3>() / sigma_);
  write_motion<2>(jacobians, 1, x[1], J_motion);
  write<2, 3>(jacobians, 2, h->J_anchor / sigma_);
  BoundedMatrix<2, Eigen::Dynamic, 2, kMaxLandmark> J;
  J.setZero(2, dim);
  J.leftCols<3>() = h->J_y / sigma_;
  for (std::size_t i = depth; i-- > 0;) {
    const ChainStep& step = chain_->steps[i];
    write_any(jacobians, static_cast<int>(5 + i), J * step.G);
    J = (J * chain_->landmark->predict_jacobian(states[i], step.dt)).eval();
  }
  write<2, 3>(jacobians, 3, J.leftCols<3>());
  write_any(jacobians, 4, J.rightCols(dim - 3));
  return true;
}

}  // namespace slammot
