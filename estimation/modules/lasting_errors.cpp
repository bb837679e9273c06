#include "estimation/modules/lasting_errors.h"

namespace slammot {

void LastingErrors::add(int track, int camera, const Eigen::Vector2d& n) {
  Sum& sum = sums_[{track, camera}];
  sum.n += n;
  if (++sum.sightings < kSightings) return;
  ++ended_.sums;
  ended_.nis += sum.n.squaredNorm() / kSightings;
  sum = {};
}

LastingErrors::Ended LastingErrors::take(const TrackRecords& records) {
  std::erase_if(sums_, [&](const auto& entry) { return !records.contains(entry.first.first); });
  return std::exchange(ended_, {});
}

}  // namespace slammot
