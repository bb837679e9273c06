#include "estimation/probation.h"

#include <stdexcept>

namespace slammot {

Probation::Probation(int frames) : frames_(frames) {
  if (frames < 1) throw std::invalid_argument("policy.probation must be at least 1");
}

bool Probation::is_passed(int track) const {
  const auto found = pixels_.find(track);
  return found != pixels_.end() && std::ssize(found->second) == frames_ - 1;
}

std::vector<Sighting> Probation::sightings(int track, double timestamp) const {
  std::vector<Sighting> result;
  const std::vector<Eigen::Vector2d>& pixels = pixels_.at(track);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto& [frame, time] = past_[i];
    const double next = i + 1 < past_.size() ? past_[i + 1].second : timestamp;
    result.push_back({static_cast<int>(pixels.size() - i), frame, next - time, pixels[i]});
  }
  return result;
}

void Probation::note(const Frame& frame, std::span<const Observation> unmatched) {
  const auto most = static_cast<std::size_t>(frames_ - 1);
  past_.emplace_back(frame.index, frame.timestamp);
  if (past_.size() > most) past_.pop_front();
  std::map<int, std::vector<Eigen::Vector2d>> seen;
  for (const Observation& z : unmatched) {
    std::vector<Eigen::Vector2d>& pixels = seen[z.track] = std::move(pixels_[z.track]);
    pixels.push_back(z.pixel);
    if (pixels.size() > most) pixels.erase(pixels.begin());
  }
  pixels_ = std::move(seen);
}

}  // namespace slammot
