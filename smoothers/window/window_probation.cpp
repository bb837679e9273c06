// Landmarks that enter with pixels of past frames (probation.h), whose cameras are in the window.
#include <algorithm>

#include "smoothers/window/window_belief.h"

namespace slammot {

// All at once, and those that fail the gate leave again. Two solutions of the window at most.
void Window::add_seen(std::span<const Candidate> candidates, std::vector<int>& refused) {
  refused.clear();
  std::vector<Candidate> inserted;
  for (const Candidate& candidate : candidates) {
    if (insert_seen(candidate)) {
      inserted.push_back(candidate);
    } else {
      refused.push_back(candidate.track);
    }
  }
  if (inserted.empty()) return;
  solve();
  std::vector<int> failed;
  find_refused(inserted, failed);
  for (const int track : failed) {
    const LandmarkId id = landmarks_.at(track).id;
    const GraphLandmark& l = graph_[id];
    graph_.variables.remove(l.y);
    if (l.is_free()) graph_.variables.remove(l.w);
    graph_.remove_landmark(id);
    landmarks_.erase(track);
  }
  if (!failed.empty()) solve();
  for (const Candidate& candidate : inserted) {
    if (histories_ && landmarks_.contains(candidate.track)) begin_history(candidate);
  }
  refused.insert(refused.end(), failed.begin(), failed.end());
}

const WindowFrame& Window::frame_of(const Sighting& seen) const {
  const auto& frames = cameras_.frames();
  return frames[frames.size() - 1 - static_cast<std::size_t>(seen.frames_before)];
}

// Its chain leads up to the newest frame.
bool Window::insert_seen(const Candidate& candidate) {
  const Sighting& first = candidate.sightings.front();
  WindowLandmark* landmark =
      insert_at(frame_of(first), first.z, candidate.prior, candidate.is_free());
  if (landmark == nullptr) return false;
  landmark->last_used = candidate.sightings.back().frame;
  GraphLandmark& l = graph_[landmark->id];
  for (const Sighting& seen : candidate.sightings) {
    if (&seen != &first) {
      graph_.add_pixel(landmark->id, frame_of(seen).camera, seen.z, l.steps());
    }
    if (candidate.is_free()) extend(*landmark, candidate.label, seen.to_next);
  }
  return true;
}

// Each pixel but the first, which defines the landmark, given all others (given_others.h).
void Window::find_refused(std::span<const Candidate> candidates, std::vector<int>& refused) {
  std::vector<int> tested;
  for (const Candidate& candidate : candidates) {
    const LandmarkId id = landmarks_.at(candidate.track).id;
    const GraphLandmark& l = graph_[id];
    const NormalEquations& equations = optimiser_.equations();
    for (int i = 1; i < std::ssize(l.pixels); ++i) {
      const GraphPixel& pixel = l.pixels[static_cast<std::size_t>(i)];
      if (!pixel.valid) {
        refused.push_back(candidate.track);
        break;
      }
      given_others_.add(equations, equations.block(id), i, pixel.at.r, true);
      tested.push_back(candidate.track);
    }
  }
  const std::vector<double> nis = given_others_.nis(optimiser_.equations());
  for (std::size_t i = 0; i < nis.size(); ++i) {
    if (!(nis[i] <= threshold_given_others_)) refused.push_back(tested[i]);
  }
  std::ranges::sort(refused);
  refused.erase(std::unique(refused.begin(), refused.end()), refused.end());
}

void Window::begin_history(const Candidate& candidate) {
  const int track = candidate.track;
  histories_->begin(track, frame_of(candidate.sightings.front()).number,
                    graph_[landmarks_.at(track).id].birth);
  for (const Sighting& seen : candidate.sightings) {
    histories_->measured(seen.z, frame_of(seen).number);
  }
}

}  // namespace slammot
