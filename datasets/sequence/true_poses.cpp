#include "datasets/sequence/true_poses.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slammot {
namespace {

constexpr double kSameTime = 1e-6;  // [s], as times are printed
constexpr double kRounding = 5e-4;  // [s], of times in whole milliseconds

CameraState camera_at(const TimedPose& pose) {
  CameraState state;
  state.position = pose.position;
  state.orientation = pose.orientation;
  return state;
}

CameraState between(const TimedPose& a, const TimedPose& b, double time) {
  const double part = (time - a.timestamp) / (b.timestamp - a.timestamp);
  CameraState state;
  state.position = a.position + part * (b.position - a.position);
  state.orientation = a.orientation.slerp(part, b.orientation);
  return state;
}

// Of the two poses around a time, of which one may be missing.
std::optional<CameraState> true_camera(const TimedPose* before, const TimedPose* after, double time,
                                       double longest_gap) {
  const auto distance = [&](const TimedPose* pose) {
    return pose == nullptr ? std::numeric_limits<double>::infinity()
                           : std::abs(pose->timestamp - time);
  };
  const TimedPose* nearest = distance(before) < distance(after) ? before : after;
  const bool bracketed =
      before != nullptr && after != nullptr && after->timestamp - before->timestamp <= longest_gap;
  if (distance(nearest) <= (bracketed ? kSameTime : kRounding)) return camera_at(*nearest);
  if (!bracketed) return std::nullopt;
  return between(*before, *after, time);
}

}  // namespace

double median_interval(const std::vector<Frame>& frames) {
  std::vector<double> intervals;
  for (size_t i = 1; i < frames.size(); ++i) {
    intervals.push_back(frames[i].timestamp - frames[i - 1].timestamp);
  }
  if (intervals.empty()) return std::numeric_limits<double>::infinity();
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

std::vector<std::optional<CameraState>> true_cameras(const std::vector<TimedPose>& poses,
                                                     const std::vector<Frame>& frames) {
  std::vector<std::optional<CameraState>> truth;
  const double interval = median_interval(frames);
  const double longest_gap = std::isfinite(interval) ? kLongestGap * interval : 0.0;
  size_t next = 0;
  for (const Frame& frame : frames) {
    while (next < poses.size() && poses[next].timestamp < frame.timestamp) ++next;
    truth.push_back(true_camera(next > 0 ? &poses[next - 1] : nullptr,
                                next < poses.size() ? &poses[next] : nullptr, frame.timestamp,
                                longest_gap));
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
