// What leaves the window with its oldest frame, what is deactivated out of view, and what returns.
#include "smoothers/window/window_belief.h"

namespace slammot {

// The oldest frame leaves before the new measurements enter. A camera's position stays on as long
// as landmarks are anchored there.
void Window::marginalise_oldest() {
  if (static_cast<int>(cameras_.frames().size()) <= options_.frames) return;
  const VariableId base = cameras_.oldest().position, next = cameras_.frames()[1].position;
  std::vector<WindowLandmark*> shifting;
  for (auto& [track, landmark] : landmarks_) {
    if (!landmark.w || landmark.base != base) continue;
    shifting.push_back(&landmark);
    if (histories_ && !landmark.noises.empty()) {
      histories_->passed(track, {&chain_states(graph_, landmark).front(), 1});
    }
  }
  for (WindowLandmark& landmark : pruned_) {
    if (landmark.base == base) shifting.push_back(&landmark);
  }
  std::set<VariableId> leaving{cameras_.oldest().motion};
  std::vector<Advance> advances;
  for (WindowLandmark* landmark : shifting) {
    for (const Advance& a : free_landmarks_.release_base(*landmark, leaving)) advances.push_back(a);
  }
  const std::set<VariableId> inactive = find_inactive(cameras_.oldest(), leaving);
  const WindowFrame oldest = cameras_.leave();
  marginalise(graph_, leaving, advances, oldest.birth_priors, inactive);
  for (WindowLandmark* landmark : shifting) free_landmarks_.shift_base(*landmark, next);
  std::erase_if(pruned_, [&](const WindowLandmark& l) { return leaving.contains(l.y); });
}

// Static landmarks that no frame after the oldest has measured, and the anchors that only such
// landmarks use.
std::set<VariableId> Window::find_inactive(const WindowFrame& oldest,
                                           std::set<VariableId>& leaving) {
  std::set<VariableId> deactivated, anchors_active, anchors_inactive;
  for (const auto& [track, l] : landmarks_) {
    const bool active = l.w || l.last_used > oldest.index;
    if (!active && !graph_.prior().inactive.contains(l.y)) deactivated.insert(l.y);
    (active ? anchors_active : anchors_inactive).insert(l.anchor);
  }
  for (const WindowLandmark& l : pruned_) {
    if (!leaving.contains(l.y)) anchors_active.insert(l.anchor);
  }
  left_anchors_.insert(oldest.position);
  release_anchors(anchors_active, anchors_inactive, leaving, deactivated);
  return deactivated;
}

// An anchor of no landmark leaves; one of inactive landmarks alone is deactivated with them.
void Window::release_anchors(const std::set<VariableId>& active,
                             const std::set<VariableId>& inactive, std::set<VariableId>& leaving,
                             std::set<VariableId>& deactivated) {
  std::set<VariableId> unused;
  for (const VariableId anchor : left_anchors_) {
    if (active.contains(anchor)) continue;
    if (!inactive.contains(anchor)) {
      unused.insert(anchor);
    } else if (!graph_.prior().inactive.contains(anchor)) {
      deactivated.insert(anchor);
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
}

void Window::reactivate_measured(const Frame& frame) {
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
