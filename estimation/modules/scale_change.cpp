#include "estimation/modules/scale_change.h"

#include <algorithm>
#include <cmath>

namespace slammot {

// Landmarks of one frame share an anchor.
void ScaleChange::measure(std::span<const LandmarkPoint> points, const TrackRecords& records) {
  after_.clear();
  for (const LandmarkPoint& p : points) {
    after_.push_back({records.at(p.track).first_frame, (p.anchor - origin_).squaredNorm()});
  }
  std::ranges::sort(after_, {}, &Anchor::frame);
  const auto same = [](const Anchor& a, const Anchor& b) { return a.frame == b.frame; };
  after_.erase(std::unique(after_.begin(), after_.end(), same), after_.end());
}

double ScaleChange::operator()(std::span<const LandmarkPoint> points, const TrackRecords& records,
                               const Eigen::Vector3d& camera) {
  constexpr double kLeast = 0.1;  // rms |a - o| over the camera's distance
  before_.swap(after_);
  measure(points, records);
  double sum_before = 0.0, sum_after = 0.0, least = 0.0;
  int common = 0;
  auto before = before_.cbegin();
  for (const Anchor& after : after_) {
    while (before != before_.cend() && before->frame < after.frame) ++before;
    if (before == before_.cend()) break;
    if (before->frame != after.frame) continue;
    ++common;
    sum_before += before->squared_distance;
    sum_after += after.squared_distance;
    least += kLeast * kLeast * (camera - origin_).squaredNorm();
  }
  if (!before_.empty() && common == 0) return kUndefined;
  const bool tells = sum_before > 0.0 && sum_after > least;
  return tells ? 0.5 * std::log(sum_after / sum_before) : 0.0;
}

}  // namespace slammot
