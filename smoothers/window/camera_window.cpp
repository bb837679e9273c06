#include "smoothers/window/camera_window.h"

#include <algorithm>

#include "models/landmarks/true_state.h"
#include "smoothers/graph/factors.h"

namespace slammot {

namespace {

constexpr int kShared = -1;  // owner of a variable that is no landmark's

}  // namespace

void CameraWindow::add(const Frame& frame, int number, const CameraState& x) {
  Eigen::VectorXd position(3), motion(kMotionSize);
  camera_to_blocks(x, position.data(), motion.data());
  WindowFrame& added = frames_.emplace_back();
  added.number = number;
  added.index = frame.index;
  added.timestamp = frame.timestamp;
  added.position = graph_.add_variable(position, nullptr, kShared);
  added.motion = graph_.add_variable(motion, &manifold_, kShared);
  if (!truth_) return;
  camera_to_blocks(true_camera(*truth_, frame.index), position.data(), motion.data());
  graph_.variable(added.position).linearisation_point = position;
  graph_.variable(added.motion).linearisation_point = motion;
}

void CameraWindow::start(const Frame& frame, const InitialCamera& initial) {
  add(frame, 0, initial.state);
  graph_.add_factor({newest().position, newest().motion}, initial_camera_cost(initial));
}

void CameraWindow::advance(const Frame& frame, double dt, const MotionNoise& noise) {
  const WindowFrame last = newest();
  const CameraState x = state(last), at = truth_ ? true_camera(*truth_, last.index) : x;
  add(frame, last.number + 1, predict(x, dt));
  graph_.add_factor({last.position, last.motion, newest().position, newest().motion},
                    camera_motion_cost(camera_noise(noise, at, dt), dt));
}

WindowFrame CameraWindow::leave() {
  WindowFrame frame = std::move(frames_.front());
  frames_.pop_front();
  left_.push_back({frame.timestamp, state(frame)});
  return frame;
}

std::deque<WindowFrame>::const_iterator CameraWindow::find(VariableId position) const {
  return std::ranges::find(frames_, position, &WindowFrame::position);
}

CameraState CameraWindow::state(const WindowFrame& frame) const {
  return camera_from_blocks(graph_.value(frame.position).data(), graph_.value(frame.motion).data());
}

CameraState CameraWindow::linearisation_point(const WindowFrame& frame) const {
  return camera_from_blocks(slammot::linearisation_point(graph_, frame.position).data(),
                            slammot::linearisation_point(graph_, frame.motion).data());
}

}  // namespace slammot
