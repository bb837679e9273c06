#include "datasets/sequence/true_poses.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slammot {
namespace {

template <typename Timed>
std::optional<double> median_interval(const std::vector<Timed>& stamps) {
  if (stamps.size() < 2) return std::nullopt;
  std::vector<double> intervals;
  for (size_t i = 1; i < stamps.size(); ++i) {
    intervals.push_back(stamps[i].timestamp - stamps[i - 1].timestamp);
  }
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

}  // namespace

std::vector<std::optional<CameraState>> match_truth(const std::vector<TimedPose>& poses,
                                                    const std::vector<Frame>& frames) {
  std::vector<std::optional<CameraState>> truth(frames.size());
  if (poses.empty()) return truth;
  const auto interval = frames.size() > 1 ? median_interval(frames) : median_interval(poses);
  const double tolerance = interval.value_or(std::numeric_limits<double>::infinity()) / 2.0;
  size_t nearest = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const auto distance = [&](size_t k) {
      return std::abs(poses[k].timestamp - frames[i].timestamp);
    };
    while (nearest + 1 < poses.size() && distance(nearest + 1) < distance(nearest)) ++nearest;
    if (distance(nearest) > tolerance) continue;
    truth[i].emplace();
    truth[i]->position = poses[nearest].position;
    truth[i]->orientation = poses[nearest].orientation;
  }
  difference_velocities(frames, truth);
  return truth;
}

namespace {

CameraState between(const TimedPose& a, const TimedPose& b, double time) {
  const double gap = b.timestamp - a.timestamp;
  const double part = gap > 0.0 ? (time - a.timestamp) / gap : 0.0;
  CameraState state;
  state.position = a.position + part * (b.position - a.position);
  state.orientation = a.orientation.slerp(part, b.orientation);
  return state;
}

}  // namespace

std::vector<std::optional<CameraState>> interpolate_truth(const std::vector<TimedPose>& poses,
                                                          const std::vector<Frame>& frames) {
  std::vector<std::optional<CameraState>> truth(frames.size());
  const double tolerance =
      median_interval(frames).value_or(std::numeric_limits<double>::infinity());
  for (size_t i = 0; i < frames.size(); ++i) {
    const double time = frames[i].timestamp;
    const auto after =
        std::lower_bound(poses.begin(), poses.end(), time,
                         [](const TimedPose& pose, double t) { return pose.timestamp < t; });
    if (after == poses.end()) break;
    const bool exactly = after->timestamp == time;
    if (!exactly && after == poses.begin()) continue;
    const TimedPose& before = exactly ? *after : *(after - 1);
    if (after->timestamp - before.timestamp > tolerance) continue;
    truth[i] = between(before, *after, time);
  }
  difference_velocities(frames, truth);
  return truth;
}

void difference_velocities(const std::vector<Frame>& frames,
                           std::vector<std::optional<CameraState>>& truth) {
  const auto known = [&](size_t i) { return i < truth.size() && truth[i].has_value(); };
  for (size_t i = 0; i < truth.size(); ++i) {
    if (!truth[i]) continue;
    const size_t from = i > 0 && known(i - 1) ? i - 1 : i;
    const size_t to = known(i + 1) ? i + 1 : i;
    if (from == to) continue;
    const double dt = frames[to].timestamp - frames[from].timestamp;
    truth[i]->velocity = (truth[to]->position - truth[from]->position) / dt;
    const Eigen::Quaterniond turn = truth[from]->orientation.conjugate() * truth[to]->orientation;
    truth[i]->angular_velocity = log_so3(turn) / dt;
  }
}

}  // namespace slammot
