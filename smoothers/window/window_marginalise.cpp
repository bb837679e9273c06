// What leaves the window with its oldest frame, what is deactivated out of view, and what returns.
#include <algorithm>

#include "smoothers/window/window_belief.h"

namespace slammot {

// One marginalisation for all of it: the oldest frame, which leaves before the new measurements
// enter, and the motions of landmarks that have become static.
void Window::marginalise() {
  leaving_.clear();
  forget_motions();
  find_departures();
  if (leaving_.oldest) {
    find_inactive(cameras_.oldest());
    cameras_.leave();
  }
  marginaliser_(graph_, leaving_);
  finish_departures();
}

void Window::marginalise_drops() {
  leaving_.clear();
  for (const auto& [track, landmark] : landmarks_) {
    if (landmark.drops) depart(landmark, nullptr, false);
  }
  for (const WindowLandmark& landmark : pruned_) {
    if (landmark.drops) depart(landmark, nullptr, true);
  }
  marginaliser_(graph_, leaving_);
  finish_departures();
}

void Window::find_departures() {
  const bool is_full = static_cast<int>(cameras_.frames().size()) > options_.frames;
  const WindowFrame* oldest = is_full ? &cameras_.oldest() : nullptr;
  if (oldest) leaving_.oldest = oldest->camera;
  for (auto& [track, landmark] : landmarks_) {
    depart(landmark, oldest, false);
    const bool shifts = oldest && landmark.is_free && landmark.base == oldest->camera.position;
    if (!histories_ || !shifts) continue;
    histories_->passed(track, {&graph_.states(graph_[landmark.id]).front(), 1});
  }
  for (const WindowLandmark& landmark : pruned_) depart(landmark, oldest, true);
}

// A camera's position stays on as long as landmarks are anchored there; the base of a free landmark
// that stands in the oldest frame moves on to the next; a landmark that was pruned leaves with the
// last frame that measured it.
void Window::depart(const WindowLandmark& landmark, const WindowFrame* oldest, bool is_pruned) {
  const GraphLandmark& l = graph_[landmark.id];
  if (is_inactive(l.y)) return;
  Departure d;
  d.landmark = landmark.id;
  if (oldest) d.since_rest = std::max(0.0, oldest->timestamp - landmark.rest_time);
  const bool is_based = oldest && landmark.base == oldest->camera.position;
  if (landmark.drops) {
    d.steps = l.steps();
    d.all_rows = d.steps > 0;
    d.absorbs_prior_of_w = d.forgets_w = true;
  } else if (landmark.is_free && is_based && l.steps() > 0) {
    d.steps = 1;
    d.absorbs_prior_of_w = true;
  }
  if (is_pruned && is_based && (!landmark.is_free || l.steps() == 0)) {
    d.leaves = d.all_rows = d.absorbs_prior_of_w = true;
  }
  if (options_.prior == WindowPrior::kCameras && oldest && l.anchor == oldest->camera.position) {
    d.steps = l.steps();
    d.leaves = d.all_rows = d.absorbs_prior_of_w = true;
  }
  const VariableId position = oldest ? oldest->camera.position : -1;
  const bool is_measured = std::ranges::any_of(
      l.pixels, [&](const GraphPixel& pixel) { return pixel.position == position; });
  const bool is_born = l.anchor == position && l.birth.rows() > 0;
  if (is_measured || is_born || d.absorbs_prior_of_w) leaving_.departures.push_back(d);
}

void Window::finish_departures() {
  const bool shifts = leaving_.oldest.has_value();
  const auto follow = [&](WindowLandmark& landmark) {
    landmark.drops = false;
    if (!shifts || landmark.base != leaving_.oldest->position) return;
    if (landmark.is_free) landmark.base = cameras_.oldest().camera.position;
    truth_.apply(landmark);
  };
  std::erase_if(pruned_, [&](const WindowLandmark& landmark) {
    return std::ranges::any_of(leaving_.departures, [&](const Departure& d) {
      return d.landmark == landmark.id && d.leaves;
    });
  });
  for (auto& [track, landmark] : landmarks_) follow(landmark);
  for (WindowLandmark& landmark : pruned_) follow(landmark);
}

// Static landmarks that no frame after the oldest has measured, and the anchors that only such
// landmarks use.
void Window::find_inactive(const WindowFrame& oldest) {
  enum Use { kUnused, kInactive, kActive };
  left_anchors_.push_back(oldest.camera.position);
  for (const VariableId anchor : left_anchors_) graph_.variables[anchor].column = kUnused;
  const auto use = [&](VariableId anchor, Use how) {
    int& mark = graph_.variables[anchor].column;
    mark = std::max(mark, static_cast<int>(how));
  };
  for (const auto& [track, landmark] : landmarks_) {
    const GraphLandmark& l = graph_[landmark.id];
    const bool active = landmark.is_free || landmark.drops || landmark.last_used > oldest.index;
    if (!active && !is_inactive(l.y)) leaving_.deactivated.push_back(l.y);
    use(l.anchor, active ? kActive : kInactive);
  }
  for (const WindowLandmark& landmark : pruned_) {
    const bool leaves = std::ranges::any_of(leaving_.departures, [&](const Departure& d) {
      return d.landmark == landmark.id && d.leaves;
    });
    if (!leaves) use(graph_[landmark.id].anchor, kActive);
  }
  std::erase_if(left_anchors_, [&](VariableId anchor) {
    const int mark = graph_.variables[anchor].column;
    if (mark == kInactive && !is_inactive(anchor)) leaving_.deactivated.push_back(anchor);
    if (mark != kUnused) return false;
    if (is_inactive(anchor)) {
      graph_.prior().inactive.forget({anchor});
      graph_.variables.remove(anchor);
    } else {
      leaving_.anchors.push_back(anchor);
    }
    return true;
  });
}

void Window::reactivate_measured() {
  returning_.clear();
  for (const int track : measured_) {
    const GraphLandmark& l = graph_[landmarks_.at(track).id];
    for (const VariableId id : {l.y, l.anchor}) {
      if (is_inactive(id)) returning_.push_back(id);
    }
  }
  std::ranges::sort(returning_);
  const auto last = std::unique(returning_.begin(), returning_.end());
  returning_.erase(last, returning_.end());
  graph_.reactivate(returning_);
}

}  // namespace slammot
