#include "estimation/modules/lasting_errors.h"

namespace slammot {

void LastingErrors::add(int track, int camera, int born, const Eigen::Vector2d& n) {
  Sum& sum = sums_[{track, camera}];
  if (sum.born != born) sum = {.born = born};  // another landmark of this track
  sum.n += n;
  if (++sum.sightings < kSightings) return;
  ++ended_.sums;
  ended_.nis += sum.n.squaredNorm() / kSightings;
  sum = {.born = born};
}

LastingErrors::Ended LastingErrors::take(const TrackRecords& records) {
  std::erase_if(sums_, [&](const auto& entry) { return !records.contains(entry.first.first); });
  return std::exchange(ended_, {});
}

}  // namespace slammot
