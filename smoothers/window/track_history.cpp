#include "smoothers/window/track_history.h"

#include <algorithm>

namespace slammot {

void TrackHistories::begin(int track, int frame, const BirthPrior& birth,
                           const Eigen::Vector3d& y) {
  TrackHistory& history = open_[track] = {};
  history.first = frame;
  history.birth = birth;
  history.born_at = y;
}

void TrackHistories::measured(const Observation& z, int frame) {
  auto& pixels = open_.at(z.track).pixels;
  const auto later =
      std::ranges::find_if(pixels, [&](const auto& other) { return other.first > frame; });
  pixels.emplace(later, frame, z);
}

void TrackHistories::discard(int track, int frame) {
  std::erase_if(open_.at(track).pixels, [&](const auto& other) { return other.first == frame; });
}

void TrackHistories::passed(int track, std::span<const LandmarkVector> states) {
  std::vector<LandmarkVector>& all = open_.at(track).states;
  all.insert(all.end(), states.begin(), states.end());
}

void TrackHistories::rested_until(int track, int frame, const LandmarkVector& state) {
  TrackHistory& history = open_.at(track);
  const auto count = static_cast<std::size_t>(frame - history.first);
  history.states.resize(count, state);
}

void TrackHistories::end(const TrackRecord& record, int frame, bool is_free,
                         std::span<const LandmarkVector> states) {
  const int track = record.track;
  open_.at(track).record = record;
  if (!open_.at(track).is_free()) {
    open_.at(track).states.clear();
  } else if (!is_free) {
    rested_until(track, frame, states.back());
  }
  passed(track, states);
  ended_.push_back(std::move(open_.at(track)));
  open_.erase(track);
}

}  // namespace slammot
