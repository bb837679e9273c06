#include "smoothers/graph/landmark_chain.h"

#include <Eigen/QR>

#include "models/observation.h"
#include "smoothers/graph/camera_manifold.h"
#include "smoothers/graph/cost_tools.h"

namespace slammot {

ChainState propagate(const Chain& chain, const Vector6d& base,
                     const std::vector<Vector6d>& noises) {
  const auto n = static_cast<Eigen::Index>(noises.size());
  ChainState state{base, Eigen::MatrixXd::Zero(6, 6 * (1 + n))};
  state.J.leftCols<6>().setIdentity();
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto k = static_cast<std::size_t>(j);
    const ChainStep& step = chain.steps[k];
    const Matrix6d F = chain.landmark->predict_jacobian(state.x, step.dt);
    state.x = chain.landmark->predict(state.x, step.dt) + step.G * noises[k];
    state.J.leftCols(6 * (j + 1)) = (F * state.J.leftCols(6 * (j + 1))).eval();
    state.J.middleCols<6>(6 * (j + 1)) = step.G;
  }
  return state;
}

std::vector<Vector6d> states(const Chain& chain, const Vector6d& base,
                             const std::vector<Vector6d>& noises) {
  std::vector<Vector6d> x{base};
  for (std::size_t i = 0; i < noises.size(); ++i) {
    const ChainStep& step = chain.steps[i];
    x.push_back(chain.landmark->predict(x.back(), step.dt) + step.G * noises[i]);
  }
  return x;
}

std::vector<Vector6d> lead_through(Chain& chain, const std::vector<Vector6d>& states,
                                   double sigma_a) {
  std::vector<Vector6d> noises;
  Vector6d x = states.front();
  for (std::size_t i = 0; i + 1 < states.size(); ++i) {
    ChainStep& step = chain.steps[i];
    x = chain.landmark->predict(x, step.dt);
    step.G = chain.landmark->noise_root(x, sigma_a, step.dt);
    // The least noise that does it best: G is singular at infinity.
    noises.push_back(step.G.completeOrthogonalDecomposition().solve(states[i + 1] - x));
    x += step.G * noises.back();
  }
  return noises;
}

ChainState static_state(const Eigen::Vector3d& y) {
  ChainState state{Vector6d::Zero(), Eigen::MatrixXd::Zero(6, 3)};
  state.x.head<3>() = y;
  state.J.topRows<3>().setIdentity();
  return state;
}

ChainPixelCost::ChainPixelCost(const Camera& camera, const Eigen::Vector2d& pixel, double sigma,
                               std::shared_ptr<const Chain> chain, int depth)
    : camera_(camera), pixel_(pixel), sigma_(sigma), chain_(std::move(chain)), depth_(depth) {
  set_num_residuals(2);
  *mutable_parameter_block_sizes() = {3, kMotionSize, 3, 3, 3};
  for (int i = 0; i < depth; ++i) mutable_parameter_block_sizes()->push_back(6);
}

// The Jacobians are carried back along the chain, from the pixel to the base: two rows through each
// step, where carrying the state's Jacobian forward would take six for each noise before.
bool ChainPixelCost::Evaluate(double const* const* x, double* residuals, double** jacobians) const {
  using Block = Eigen::Map<const Eigen::Vector3d>;
  const auto depth = static_cast<std::size_t>(depth_);
  std::vector<Vector6d> states(depth + 1);
  states[0] << Block(x[3]), Block(x[4]);
  for (std::size_t i = 0; i < depth; ++i) {
    const ChainStep& step = chain_->steps[i];
    states[i + 1] = chain_->landmark->predict(states[i], step.dt) +
                    step.G * Eigen::Map<const Vector6d>(x[5 + i]);
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
  Eigen::Matrix<double, 2, 6> J = Eigen::Matrix<double, 2, 6>::Zero();
  J.leftCols<3>() = h->J_y / sigma_;
  for (std::size_t i = depth; i-- > 0;) {
    const ChainStep& step = chain_->steps[i];
    write<2, 6>(jacobians, static_cast<int>(5 + i), J * step.G);
    J = (J * chain_->landmark->predict_jacobian(states[i], step.dt)).eval();
  }
  write<2, 3>(jacobians, 3, J.leftCols<3>());
  write<2, 3>(jacobians, 4, J.rightCols<3>());
  return true;
}

}  // namespace slammot
