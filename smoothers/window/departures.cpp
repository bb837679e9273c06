#include "smoothers/window/departures.h"

#include <algorithm>

namespace slammot {

namespace {

bool is_measured_by(const GraphLandmark& l, const WindowFrame* frame) {
  return frame && std::ranges::any_of(l.pixels, [&](const GraphPixel& pixel) {
           return pixel.position == frame->camera.position;
         });
}

}  // namespace

// Where the scale is kept. What was linearised at another estimate would seem to tell it.
void Departures::linearise() {
  if (graph_.keeps_scale()) graph_.linearise();
}

void Departures::marginalise(int frames, TrackHistories* histories) {
  linearise();
  leaving_.clear();
  const bool is_full = static_cast<int>(cameras_.frames().size()) > frames;
  find(is_full ? &cameras_.oldest() : nullptr, histories);
  if (is_full) {
    find_inactive(cameras_.oldest());
    cameras_.leave();
  }
  marginaliser_(graph_, leaving_);
  finish();
}

void Departures::marginalise_motions() {
  linearise();
  leaving_.clear();
  for (const auto& [track, landmark] : landmarks_.current) {
    if (landmark.drops) add(landmark, nullptr, false);
  }
  for (const WindowLandmark& landmark : landmarks_.pruned) {
    if (landmark.drops) add(landmark, nullptr, true);
  }
  marginaliser_(graph_, leaving_);
  finish();
}

void Departures::move_to(const WindowLandmark& landmark, double rest_time,
                         const WindowFrame& base) {
  if (base.timestamp <= rest_time) return;
  linearise();
  const int dim = graph_.models().landmark->dim();
  ChainStep step;
  step.dt = base.timestamp - rest_time;
  step.G.setZero(dim, dim);
  step.noise.setZero(dim);
  GraphLandmark& l = graph_[landmark.id];
  l.chain.push_back(step);
  for (GraphPixel& pixel : l.pixels) pixel.depth = pixel.time <= base.timestamp ? 0 : 1;
  leaving_.clear();
  Departure& d = leaving_.departures.emplace_back();
  d.landmark = landmark.id;
  d.steps = 1;
  d.absorbs_prior_of_w = true;
  d.until = base.timestamp;
  marginaliser_(graph_, leaving_);
}

void Departures::set_apart(const WindowLandmark& landmark) {
  leaving_.clear();
  if (graph_.prior().active.find(graph_[landmark.id].y) == nullptr) return;
  linearise();
  leaving_.apart = landmark.id;
  marginaliser_(graph_, leaving_);
}

void Departures::find(const WindowFrame* oldest, TrackHistories* histories) {
  if (oldest) leaving_.oldest = oldest->camera;
  for (const auto& [track, landmark] : landmarks_.current) {
    add(landmark, oldest, false);
    const bool shifts = oldest && landmark.is_free && landmark.base == oldest->camera.position;
    if (!histories || !shifts) continue;
    histories->passed(track, {&graph_.states(graph_[landmark.id]).front(), 1});
  }
  for (const WindowLandmark& landmark : landmarks_.pruned) add(landmark, oldest, true);
}

// A landmark has a departure if the frame that leaves measured it or saw its birth, if its w drops,
// or if it was pruned and the prior holds it.
void Departures::add(const WindowLandmark& landmark, const WindowFrame* oldest, bool is_pruned) {
  const GraphLandmark& l = graph_[landmark.id];
  if (is_inactive(l.y)) return;
  const Departure d = departure_of(landmark, oldest, is_pruned);
  const bool is_born = oldest && l.anchor == oldest->camera.position && l.birth.rows() > 0;
  if (is_measured_by(l, oldest) || is_born || d.absorbs_prior_of_w)
    leaving_.departures.push_back(d);
}

// The base of a free landmark that stands in the oldest frame moves on to the next. A landmark that
// was pruned leaves whole, with the first frame that measured it, or at once where that has left:
// the core would be several times as large with all that is never seen again.
Departure Departures::departure_of(const WindowLandmark& landmark, const WindowFrame* oldest,
                                   bool is_pruned) const {
  const GraphLandmark& l = graph_[landmark.id];
  const int steps = l.steps();
  const bool is_based = oldest && landmark.base == oldest->camera.position;
  Departure d;
  d.landmark = landmark.id;
  if (landmark.drops) {
    d.steps = steps;
    d.all_rows = steps > 0;
    d.absorbs_prior_of_w = d.forgets_w = true;
  } else if (landmark.is_free && is_based && steps > 0) {
    d.steps = 1;
    d.absorbs_prior_of_w = true;
  }
  const bool has_begun_to_leave =
      is_based || !graph_.variables[l.y].is_private || is_measured_by(l, oldest);
  if (is_pruned && oldest && has_begun_to_leave) {
    d.steps = steps;
    d.leaves = d.all_rows = d.absorbs_prior_of_w = true;
  }
  return d;
}

bool Departures::leaves(const WindowLandmark& landmark) const {
  return std::ranges::any_of(leaving_.departures, [&](const Departure& d) {
    return d.landmark == landmark.id && d.leaves;
  });
}

// Static landmarks that no frame after the oldest has measured, and the anchors that only such
// landmarks use. One whose motion is remembered stays, or the motion could not be released.
void Departures::find_inactive(const WindowFrame& oldest) {
  mark_anchors(oldest);
  std::erase_if(left_anchors_, [&](const LeftAnchor& anchor) {
    const VariableId id = anchor.position;
    if (anchor.use == Use::kInactive && !is_inactive(id)) leaving_.deactivated.push_back(id);
    if (anchor.use != Use::kUnused) return false;
    if (is_inactive(id)) {
      graph_.prior().inactive.forget({id});
      graph_.variables.remove(id);
    } else {
      leaving_.anchors.push_back(id);
    }
    return true;
  });
}

void Departures::mark_anchors(const WindowFrame& oldest) {
  const VariableId position = oldest.camera.position;
  const auto later = std::ranges::lower_bound(left_anchors_, position, {}, &LeftAnchor::position);
  left_anchors_.insert(later, {position, Use::kUnused});
  for (LeftAnchor& anchor : left_anchors_) anchor.use = Use::kUnused;
  for (const auto& [track, landmark] : landmarks_.current) {
    const GraphLandmark& l = graph_[landmark.id];
    const bool is_active =
        landmark.is_free || landmark.drops || l.constrained || landmark.last_used > oldest.index;
    if (!is_active && !is_inactive(l.y)) leaving_.deactivated.push_back(l.y);
    use(l.anchor, is_active ? Use::kActive : Use::kInactive);
  }
  for (const WindowLandmark& landmark : landmarks_.pruned) {
    if (!leaves(landmark)) use(graph_[landmark.id].anchor, Use::kActive);
  }
}

void Departures::use(VariableId anchor, Use how) {
  const auto found = std::ranges::lower_bound(left_anchors_, anchor, {}, &LeftAnchor::position);
  if (found == left_anchors_.end() || found->position != anchor) return;  // in the window
  found->use = std::max(found->use, how);
}

void Departures::finish() {
  std::erase_if(landmarks_.pruned,
                [&](const WindowLandmark& landmark) { return leaves(landmark); });
  landmarks_.for_each([&](WindowLandmark& landmark) {
    landmark.drops = false;
    if (!leaving_.oldest || landmark.base != leaving_.oldest->position) return;
    if (landmark.is_free) landmark.base = cameras_.oldest().camera.position;
  });
}

void Departures::reactivate(std::span<const int> tracks) {
  returning_.clear();
  for (const int track : tracks) {
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
