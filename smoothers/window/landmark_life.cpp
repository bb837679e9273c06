// What becomes of a landmark in the window: it enters, comes to rest, is free again, is removed.
#include "models/points/initialisation.h"
#include "smoothers/window/window.h"

namespace slammot {

// `condition` states that they never moved: their window's measurements change, and with them the
// estimate, but of one that has entered with this frame no motion was seen. `drop` marginalises w,
// at the next update.
void Window::collapse(std::span<const int> tracks) {
  bool changes_estimate = false;
  for (const int track : tracks) {
    WindowLandmark& landmark = landmarks_.at(track);
    const GraphLandmark& l = graph_[landmark.id];
    const bool is_new =
        l.anchor == cameras_.newest().camera.position && graph_.variables[l.w].is_private;
    if (histories_) {
      std::vector<LandmarkVector> states = graph_.states(graph_[landmark.id]);
      states.pop_back();
      histories_->passed(track, states);
    }
    landmark.is_free = false;
    graph_.consider(landmark.id, false);
    const double rest_time = cameras_.find(landmark.base)->timestamp;
    landmark.base = cameras_.newest().camera.position;
    if (condition_) {
      graph_.constrain_to_rest(landmark.id, rest_time);
      if (!remembers_) graph_.forget_motion(landmark.id);
      if (is_new) optimiser_.equations().add(graph_, landmark.id);
      changes_estimate = changes_estimate || !is_new;
    } else {
      landmark.drops = true;
    }
  }
  if (changes_estimate) take_step();
}

void Window::forget_motions(std::span<const int> tracks) {
  for (const int track : tracks) graph_.forget_motion(landmarks_.at(track).id);
}

// y stays what it is, at the newest frame, where a chain begins.
void Window::free(int track, const LandmarkPrior& prior) {
  WindowLandmark& landmark = landmarks_.at(track);
  if (landmark.drops) {
    departures_.marginalise_motions();
    refactorise();
  }
  const WindowFrame& newest = cameras_.newest();
  if (histories_) histories_->rested_until(track, newest.number, marginals_.at_rest(landmark));
  landmark.base = newest.camera.position;
  landmark.is_free = true;
  graph_.forget_motion(landmark.id);
  graph_.free_landmark(landmark.id, functions_.prior_sigmas(prior));
}

// It is free with its pixels of the window and all that the prior knows of it, and the window is
// solved once more.
void Window::release(std::span<const int> tracks, const TrackRecords& records) {
  for (const int track : tracks) {
    if (graph_[landmarks_.at(track).id].constrained) {
      release(track);
    } else {
      free(track, records.at(track).prior);
    }
  }
  take_step();
}

void Window::release(int track) {
  WindowLandmark& landmark = landmarks_.at(track);
  const GraphLandmark& l = graph_[landmark.id];
  const WindowFrame& base = base_of_release(l, cameras_);
  if (histories_) histories_->rested_until(track, base.number, marginals_.at_rest(landmark));
  const double rest_time = l.constrained->rest_time;
  landmark.is_free = true;
  landmark.base = base.camera.position;
  graph_.release_motion(landmark.id);
  departures_.move_to(landmark, rest_time, base);
  begin_chain(graph_, landmark.id, base, cameras_);
}

// Its measurements stay in the window until they leave.
void Window::remove(std::span<const int> tracks, const TrackRecords& records) {
  for (const int track : tracks) {
    WindowLandmark& landmark = landmarks_.at(track);
    graph_.forget_motion(landmark.id);
    if (histories_) end_history(landmark, records.at(track));
    const VariableId y = graph_[landmark.id].y;
    if (!graph_.variables[y].is_active) {
      graph_.prior().inactive.forget({y});
      graph_.variables.remove(y);
      graph_.remove_landmark(landmark.id);
    } else {
      if (landmark.is_free) {
        end_chain(graph_[landmark.id]);
      } else {  // the last frame that can have measured it
        landmark.base = cameras_.newest().camera.position;
      }
      landmarks_.pruned.push_back(landmark);
    }
    landmarks_.current.erase(track);
  }
}

// Thesis 2.1.3, (2.7), as factors: the first pixel, and the priors of inverse depth and motion.
bool Window::add(const FirstSight& seen, const LandmarkPrior& prior, bool is_free) {
  const WindowFrame& newest = cameras_.newest();
  const bool is_shared = graph_.scene && !seen.has_own_depth;
  const double depth = is_shared                 ? graph_.variables[graph_.scene->scene].value(0)
                       : seen.is_of_one_camera() ? seen.prior.inverse_depth
                                                 : seen.inverse_depth;
  const auto here = initialise(setup_.camera, functions_.point, cameras_.state(newest).orientation,
                               seen.pixel, depth);
  if (!here) return false;
  WindowLandmark& landmark = insert(seen.z.track, newest.camera.position, here->y);
  landmark.is_free = is_free;
  GraphLandmark& l = graph_[landmark.id];
  l.birth.kind = is_shared ? BirthPrior::Kind::kSharedDepth : BirthPrior::Kind::kDepth;
  l.birth.inverse_depth = seen.prior.inverse_depth;
  l.birth.spread = {seen.prior.sigma, is_shared && prior.spread_follows_mean ? depth : 0.0};
  l.birth.scene = is_shared ? graph_.scene->scene : -1;
  graph_.add_pixel(landmark.id, newest.camera, seen.z, 0);
  for (const Observation& z : seen.others) graph_.add_pixel(landmark.id, newest.camera, z, 0);
  if (is_free) graph_.free_landmark(landmark.id, functions_.prior_sigmas(prior));
  if (histories_) {
    histories_->begin(seen.z.track, newest.number, l.birth, here->y);
    histories_->measured(seen.z, newest.number);
    for (const Observation& z : seen.others) histories_->measured(z, newest.number);
  }
  graph_.linearise(l);
  optimiser_.equations().add(graph_, landmark.id);
  return true;
}

WindowLandmark& Window::insert(int track, VariableId anchor, const Eigen::Vector3d& y) {
  WindowLandmark& landmark = landmarks_.current[track];
  landmark = {};
  landmark.track = track;
  landmark.id = graph_.add_landmark(anchor, y);
  landmark.last_used = cameras_.newest().index;
  landmark.base = anchor;
  return landmark;
}

}  // namespace slammot
