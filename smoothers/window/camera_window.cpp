#include "smoothers/window/camera_window.h"

#include <algorithm>

namespace slammot {

void CameraWindow::add(const Frame& frame, int number, const CameraState& x) {
  frames_.push_back({number, frame.index, frame.timestamp, graph_.add_camera(x)});
  frames_.back().camera.time = frame.timestamp;
}

void CameraWindow::start(const Frame& frame, const InitialCamera& initial) {
  add(frame, 0, initial.state);
  graph_.add_initial(newest().camera, initial);
}

void CameraWindow::advance(const Frame& frame, double dt, const MotionNoise& noise) {
  const WindowFrame last = newest();
  const CameraState x = state(last);
  add(frame, last.number + 1, predict(x, dt));
  graph_.add_motion(last.camera, newest().camera, camera_noise(noise, x, dt), dt);
}

void CameraWindow::leave() {
  left_.push_back({frames_.front().timestamp, state(frames_.front())});
  frames_.erase(frames_.begin());
}

std::vector<WindowFrame>::const_iterator CameraWindow::find(VariableId position) const {
  return std::ranges::find(frames_, position,
                           [](const WindowFrame& f) { return f.camera.position; });
}

std::vector<CameraState> CameraWindow::all() const {
  std::vector<CameraState> states;
  for (const Left& left : left_) states.push_back(left.state);
  for (const WindowFrame& f : frames_) states.push_back(state(f));
  return states;
}

}  // namespace slammot
