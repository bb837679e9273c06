// What the window believes: states with their marginal covariances.
#include "models/so3.h"
#include "smoothers/window/window_estimator.h"

namespace slammot {

// The newest camera with its marginal covariance at the last linearisation, in the coordinates of
// the estimate.
void Window::estimate_camera(const NormalEquations& equations, const Step& last) {
  const std::vector<std::vector<VariableId>> camera{{newest().position, newest().motion}};
  Matrix12d P = equations.covariances(camera).front();
  if (!graph_.first_estimates()) {
    const Eigen::Vector3d turn = last.at(newest().motion).head<3>();
    const Eigen::Matrix3d J = right_jacobian_so3(turn);
    P.middleRows<3>(kRotation) = (J * P.middleRows<3>(kRotation)).eval();
    P.middleCols<3>(kRotation) = (P.middleCols<3>(kRotation) * J.transpose()).eval();
  }
  camera_ = {newest().timestamp, state(newest()), 0.5 * (P + P.transpose())};
}

std::vector<LandmarkEstimate> Window::estimate(const std::vector<int>& tracks) const {
  if (tracks.empty()) return {};
  std::vector<LinearForm> forms;
  std::vector<LandmarkBelief> beliefs;
  std::vector<Eigen::MatrixXd> far;
  for (const int track : tracks) {
    LandmarkForm made = landmark_form(graph_, landmarks_.at(track));
    beliefs.push_back(std::move(made.belief));
    LinearForm& form = forms.emplace_back(std::move(made.form));
    far.push_back(replace_far(graph_, form));
  }
  const std::vector<Eigen::MatrixXd> P = NormalEquations(graph_).covariances(forms);
  std::vector<LandmarkEstimate> estimates;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    beliefs[i].covariance = P[i] + far[i];
    estimates.push_back(landmark_estimate(functions_, landmarks_.at(tracks[i]).record, beliefs[i]));
  }
  return estimates;
}

std::vector<LandmarkEstimate> Window::landmarks() const {
  std::vector<int> tracks;
  for (const auto& [track, landmark] : landmarks_) tracks.push_back(track);
  return estimate(tracks);
}

std::vector<LandmarkEstimate> Window::landmarks_measured(int index) const {
  std::vector<int> tracks;
  for (const auto& [track, landmark] : landmarks_) {
    if (landmark.record.last_frame == index) tracks.push_back(track);
  }
  return estimate(tracks);
}

// Cameras as they left the window, without covariances, which belong to that moment and are not
// kept; then those still in it, converged, with theirs.
std::vector<CameraEstimate> Window::smoothed(StageListener&) {
  optimise(graph_, options_.iterations, options_.cost_tolerance);
  for (int i = 0; i < kMaxRefreshes && refresh_noises() > kNegligibleNoise; ++i) {
    optimise(graph_, options_.iterations, options_.cost_tolerance);
  }
  graph_.linearise();
  std::vector<std::vector<VariableId>> sets;
  for (const WindowFrame& f : frames_) sets.push_back({f.position, f.motion});
  const std::vector<Eigen::MatrixXd> P = NormalEquations(graph_).covariances(sets);
  std::vector<CameraEstimate> result;
  for (const auto& [timestamp, x] : left_) {
    result.push_back({timestamp, x, Matrix12d::Constant(kUndefined)});
  }
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    result.push_back({frames_[i].timestamp, state(frames_[i]), P[i]});
  }
  return result;
}

}  // namespace slammot
