// What leaves the window with its oldest frame, what rests out of view, and what comes back.
#include "smoothers/window/window_estimator.h"

namespace slammot {

// The oldest frame leaves before the new measurements enter. A camera's position stays on as long
// as landmarks are anchored there.
void Window::marginalise_oldest() {
  if (static_cast<int>(frames_.size()) <= options_.frames) return;
  const WindowFrame oldest = frames_.front();
  const VariableId next = frames_[1].position;
  left_.push_back({oldest.timestamp, state(oldest)});
  std::vector<WindowLandmark*> moving;
  for (auto& [track, landmark] : landmarks_) {
    if (landmark.w && landmark.base == oldest.position) moving.push_back(&landmark);
  }
  for (WindowLandmark& landmark : dead_) {
    if (landmark.base == oldest.position) moving.push_back(&landmark);
  }
  std::set<VariableId> leaving{oldest.motion};
  std::vector<Advance> advances;
  for (WindowLandmark* landmark : moving) {
    for (const Advance& a : leave_base(*landmark, leaving)) advances.push_back(a);
  }
  const std::set<VariableId> resting = rest(oldest, leaving);
  marginalise(graph_, leaving, advances, oldest.knowledge, resting);
  for (WindowLandmark* landmark : moving) enter_base(*landmark, next);
  std::erase_if(dead_, [&](const WindowLandmark& l) { return leaving.contains(l.y); });
  frames_.pop_front();
}

// Static landmarks that no frame after the oldest has measured rest, and so do anchors of which all
// landmarks rest; an anchor of no landmark leaves.
std::set<VariableId> Window::rest(const WindowFrame& oldest, std::set<VariableId>& leaving) {
  std::set<VariableId> resting, anchors_near, anchors_far;
  for (const auto& [track, l] : landmarks_) {
    const bool near = l.w || l.record.last_frame > oldest.index;
    if (!near && !graph_.prior().inactive.contains(l.y)) resting.insert(l.y);
    (near ? anchors_near : anchors_far).insert(l.anchor);
  }
  for (const WindowLandmark& l : dead_) {
    if (!leaving.contains(l.y)) anchors_near.insert(l.anchor);
  }
  left_anchors_.insert(oldest.position);
  std::set<VariableId> unused;
  for (const VariableId anchor : left_anchors_) {
    if (anchors_near.contains(anchor)) continue;
    if (!anchors_far.contains(anchor)) {
      unused.insert(anchor);
    } else if (!graph_.prior().inactive.contains(anchor)) {
      resting.insert(anchor);
    }
  }
  for (const VariableId anchor : unused) {
    left_anchors_.erase(anchor);
    if (graph_.prior().inactive.contains(anchor)) {
      graph_.remove_variables({anchor});
    } else {
      leaving.insert(anchor);
    }
  }
  return resting;
}

void Window::bring_back_measured(const Frame& frame) {
  std::set<VariableId> back;
  for (const Observation& z : frame.observations) {
    const auto it = landmarks_.find(z.track);
    if (it == landmarks_.end()) continue;
    for (const VariableId id : {it->second.y, it->second.anchor}) {
      if (graph_.prior().inactive.contains(id)) back.insert(id);
    }
  }
  graph_.reactivate({back.begin(), back.end()});
}

}  // namespace slammot
