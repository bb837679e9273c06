#include "estimation/probation.h"

#include <stdexcept>

namespace slammot {

Probation::Probation(int frames) : frames_(frames) {
  if (frames < 1) throw std::invalid_argument("policy.probation must be at least 1");
}

bool Probation::is_passed(int track) const {
  const auto found = seen_.find(track);
  return found != seen_.end() && std::ssize(found->second) == frames_ - 1;
}

std::vector<Sighting> Probation::sightings(int track, double timestamp) const {
  std::vector<Sighting> result;
  const std::vector<Observation>& all = seen_.at(track);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& [frame, time] = past_[i];
    const double next = i + 1 < past_.size() ? past_[i + 1].second : timestamp;
    result.push_back({static_cast<int>(all.size() - i), frame, next - time, all[i]});
  }
  return result;
}

void Probation::note(const Frame& frame, std::span<const Observation> unmatched) {
  const auto most = static_cast<std::size_t>(frames_ - 1);
  past_.emplace_back(frame.index, frame.timestamp);
  if (past_.size() > most) past_.pop_front();
  std::map<int, std::vector<Observation>> now;
  for (const Observation& z : unmatched) {
    std::vector<Observation>& all = now[z.track] = std::move(seen_[z.track]);
    all.push_back(z);
    if (all.size() > most) all.erase(all.begin());
  }
  seen_ = std::move(now);
}

}  // namespace slammot
