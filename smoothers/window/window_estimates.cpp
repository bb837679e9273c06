// What the window says of its cameras and landmarks, and what it tells a batch.
#include "smoothers/solver/ceres_solve.h"
#include "smoothers/window/window_belief.h"

namespace slammot {

namespace {

constexpr int kCeresIterations = 1000;
constexpr double kCeresTolerance = 1e-18;  // below rounding: until steps change nothing

}  // namespace

// At the optimum of Ceres the equations are factorised for the marginals, and the step that they
// give is taken too: Ceres judges steps by the cost, whose rounding hides a last 1e-6 sigma.
void Window::solve() {
  if (options_.solver == WindowSolver::kCeres) {
    solve_with_ceres(graph_, kCeresIterations, kCeresTolerance);
    graph_.linearise();
    optimiser_.take_step(graph_, cameras_.newest().camera);
  } else {
    optimiser_(graph_, cameras_.newest().camera, options_.iterations, options_.linearisation_error);
  }
  F_.setIdentity();
  Q_.setZero();
}

// Graph::is_at_pole(). Where every step is taken, none is held back by a pole.
bool Window::leave_out_poles() {
  if (optimiser_.takes_every_step()) return false;
  bool any = false;
  const auto leave_out = [&](const WindowLandmark& landmark, bool is_pruned) {
    std::erase_if(graph_[landmark.id].pixels, [&](const GraphPixel& pixel) {
      if (!graph_.is_at_pole(pixel)) return false;
      if (!is_pruned) forget_pixel(landmark.track, pixel.position);
      any = true;
      return true;
    });
  };
  for (const auto& [track, landmark] : landmarks_) leave_out(landmark, false);
  for (const WindowLandmark& landmark : pruned_) leave_out(landmark, true);
  return any;
}

// One that is in the graph no more.
void Window::forget_pixel(int track, VariableId position) {
  if (position == cameras_.newest().camera.position) std::erase(used_, track);
  if (histories_) histories_->let_go(track, cameras_.find(position)->number);
}

// Where there was nothing to solve.
void Window::refactorise() {
  graph_.linearise();
  optimiser_.equations().factorise(graph_, cameras_.newest().camera);
}

// The newest camera with its marginal covariance at the last linearisation, in the coordinates of
// the estimate.
void Window::estimate_camera() {
  const WindowFrame& newest = cameras_.newest();
  const Matrix12d P = optimiser_.equations().camera_covariance();
  camera_ = {newest.timestamp, cameras_.state(newest), 0.5 * (P + P.transpose())};
}

double Window::refresh_noises() {
  if (truth_) return 0.0;  // they are those of the true states
  double change = 0.0;
  for (GraphLandmark& l : graph_.landmarks) {
    if (l.is_alive) change = std::max(change, graph_.refresh_noises(l));
  }
  return change;
}

// Cameras as they left the window, without covariances, which belong to that moment and are not
// kept; then those still in it, converged, with theirs.
std::vector<CameraEstimate> Window::smoothed() {
  marginalise_drops();
  solve();
  for (int i = 0; i < kMaxRefreshes && refresh_noises() > kNegligibleNoise; ++i) solve();
  refactorise();
  std::vector<CameraEstimate> result;
  for (const CameraWindow::Left& left : cameras_.left()) {
    result.push_back({left.timestamp, left.state, Matrix12d::Constant(kUndefined)});
  }
  for (const WindowFrame& f : cameras_.frames()) {
    result.push_back({f.timestamp, cameras_.state(f),
                      optimiser_.equations().camera_covariance(graph_, f.camera)});
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

LandmarkVector Window::at_rest(const WindowLandmark& landmark) const {
  return landmark_state(graph_.newest_state(graph_[landmark.id]).head<3>(),
                        MotionVector::Zero(functions_.motion));
}

void Window::end_history(const WindowLandmark& landmark, const TrackRecord& record) const {
  const std::vector<LandmarkVector> states = landmark.is_free
                                                 ? graph_.states(graph_[landmark.id])
                                                 : std::vector<LandmarkVector>{at_rest(landmark)};
  histories_->end(record, cameras_.newest().number, landmark.is_free, states);
}

}  // namespace slammot
