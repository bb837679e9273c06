#include "smoothers/window/camera_window.h"

#include <algorithm>

#include "models/landmarks/true_state.h"

namespace slammot {

void CameraWindow::add(const Frame& frame, int number, const CameraState& x) {
  frames_.push_back({number, frame.index, frame.timestamp, graph_.add_camera(x)});
  if (!truth_) return;
  const GraphCamera& camera = newest().camera;
  const CameraState at = true_camera(*truth_, frame.index);
  Vector6d rates;
  rates << at.velocity, at.angular_velocity;
  graph_.variables[camera.position].linearisation_point = at.position;
  graph_.variables[camera.orientation].linearisation_point = at.orientation.coeffs();
  graph_.variables[camera.rates].linearisation_point = rates;
}

void CameraWindow::start(const Frame& frame, const InitialCamera& initial) {
  add(frame, 0, initial.state);
  graph_.add_initial(newest().camera, initial);
}

void CameraWindow::advance(const Frame& frame, double dt, const MotionNoise& noise) {
  const WindowFrame last = newest();
  const CameraState x = state(last), at = truth_ ? true_camera(*truth_, last.index) : x;
  add(frame, last.number + 1, predict(x, dt));
  graph_.add_motion(last.camera, newest().camera, camera_noise(noise, at, dt), dt);
}

void CameraWindow::leave() {
  left_.push_back({frames_.front().timestamp, state(frames_.front())});
  frames_.erase(frames_.begin());
}

std::vector<WindowFrame>::const_iterator CameraWindow::find(VariableId position) const {
  return std::ranges::find(frames_, position,
                           [](const WindowFrame& f) { return f.camera.position; });
}

}  // namespace slammot
