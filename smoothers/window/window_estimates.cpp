// What the window says of its cameras, and what it tells a batch.
#include "models/so3.h"
#include "smoothers/window/window_belief.h"

namespace slammot {

// The newest camera with its marginal covariance at the last linearisation, in the coordinates of
// the estimate.
void Window::estimate_camera() {
  const WindowFrame& newest = cameras_.newest();
  const std::vector<std::vector<VariableId>> camera{{newest.position, newest.motion}};
  Matrix12d P = optimum_->equations.covariances(camera).front();
  if (!graph_.prior().first_estimates()) {
    const Eigen::Vector3d turn = optimum_->last_step.at(newest.motion).head<3>();
    const Eigen::Matrix3d J = right_jacobian_so3(turn);
    P.middleRows<3>(kRotation) = (J * P.middleRows<3>(kRotation)).eval();
    P.middleCols<3>(kRotation) = (P.middleCols<3>(kRotation) * J.transpose()).eval();
  }
  camera_ = {newest.timestamp, cameras_.state(newest), 0.5 * (P + P.transpose())};
}

// J of a pixel's factor in the coordinates that the last step was taken in.
Eigen::MatrixXd Window::before_last_step(const Factor& factor) const {
  Eigen::MatrixXd J = factor.J;
  if (graph_.prior().first_estimates()) return J;
  for (std::size_t i = 0; i < factor.variables.size(); ++i) {
    if (!factor.at[i]->manifold) continue;
    const Eigen::Vector3d turn = optimum_->last_step.at(factor.variables[i]).head<3>();
    J.middleCols<3>(factor.offset[i]) *= right_jacobian_so3(turn);
  }
  return J;
}

// Cameras as they left the window, without covariances, which belong to that moment and are not
// kept; then those still in it, converged, with theirs.
std::vector<CameraEstimate> Window::smoothed() {
  optimise(graph_, options_.iterations, options_.cost_tolerance);
  for (int i = 0; i < kMaxRefreshes && refresh_noises() > kNegligibleNoise; ++i) {
    optimise(graph_, options_.iterations, options_.cost_tolerance);
  }
  graph_.linearise();
  std::vector<std::vector<VariableId>> sets;
  for (const WindowFrame& f : cameras_.frames()) sets.push_back({f.position, f.motion});
  const std::vector<Eigen::MatrixXd> P = NormalEquations(graph_).covariances(sets);
  std::vector<CameraEstimate> result;
  for (const CameraWindow::Left& left : cameras_.left()) {
    result.push_back({left.timestamp, left.state, Matrix12d::Constant(kUndefined)});
  }
  for (std::size_t i = 0; i < P.size(); ++i) {
    const WindowFrame& f = cameras_.frames()[i];
    result.push_back({f.timestamp, cameras_.state(f), P[i]});
  }
  return result;
}

std::vector<CameraState> Window::all_cameras() const {
  std::vector<CameraState> states;
  for (const CameraWindow::Left& left : cameras_.left()) states.push_back(left.state);
  for (const WindowFrame& f : cameras_.frames()) states.push_back(cameras_.state(f));
  return states;
}

void Window::end_histories(const TrackRecords& records) const {
  for (const auto& [track, landmark] : landmarks_) end_history(landmark, records.at(track));
}

LandmarkVector Window::at_rest(const WindowLandmark& l) const {
  return landmark_state(graph_.value(l.y), MotionVector::Zero(functions_.motion));
}

void Window::end_history(const WindowLandmark& l, const TrackRecord& record) const {
  const std::vector<LandmarkVector> states =
      l.w ? chain_states(graph_, l) : std::vector<LandmarkVector>{at_rest(l)};
  histories_->end(record, cameras_.newest().number, l.w.has_value(), states);
}

}  // namespace slammot
