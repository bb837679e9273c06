#include "eval/metrics/accuracy.h"

#include <algorithm>
#include <numbers>

#include "eval/metrics/alignment.h"
#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kAtRest = 1e-3;  // [m] from the first position, that jitter stays within

// T_a^-1 T_b.
CameraState between(const CameraState& a, const CameraState& b) {
  CameraState relative;
  relative.orientation = a.orientation.conjugate() * b.orientation;
  relative.position = a.orientation.conjugate() * (b.position - a.position);
  return relative;
}

void add_relative_errors(const std::vector<PosePair>& pairs, double interval, Accuracy& result) {
  std::vector<double> positions, scaled, rotations;
  const double slack = 1e-6;  // a second is a second, also when timestamps are rounded
  size_t j = 0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const double until = pairs[i].estimate.timestamp + interval - slack;
    while (j < pairs.size() && pairs[j].estimate.timestamp < until) ++j;
    if (j == pairs.size()) break;
    const CameraState truth = between(pairs[i].truth, pairs[j].truth);
    const CameraState estimate = between(pairs[i].estimate.state, pairs[j].estimate.state);
    const CameraState error = between(truth, estimate);
    positions.push_back(error.position.norm());
    scaled.push_back((result.scale * estimate.position - truth.position).norm());
    rotations.push_back(log_so3(error.orientation).norm() * kDegrees);
  }
  result.relative_pairs = static_cast<int>(positions.size());
  result.relative_position_rmse = root_mean_square(positions);
  result.relative_scaled_rmse = root_mean_square(scaled);
  result.relative_rotation_rmse_deg = root_mean_square(rotations);
}

void add_path_errors(const std::vector<PosePair>& pairs, Accuracy& result) {
  const double tenth[] = {true_path_length(pairs) / static_cast<double>(kTenths)};
  const double at_rest = kAtRest / static_cast<double>(kTenths);
  result.over_tenths =
      distance_errors(pairs, {tenth, tenth[0] > at_rest ? 1u : 0u}, 1, result.scale);
  result.over_kitti = distance_errors(pairs, kKittiLengths, kKittiStep, result.scale);
  result.scale_along_path = scale_along_path(pairs);
}

struct Paths {
  std::vector<Eigen::Vector3d> estimate, truth;
};

Paths paths_of(const std::vector<PosePair>& pairs) {
  Paths paths;
  for (const PosePair& pair : pairs) {
    paths.estimate.push_back(pair.estimate.state.position);
    paths.truth.push_back(pair.truth.position);
  }
  return paths;
}

// Fewer than three poses are aligned by any rotation about their line, or by any at all.
constexpr std::size_t kFewestAligned = 3;
// Jitter adds to the path of a camera at rest, not to this.
double extent(const std::vector<Eigen::Vector3d>& positions) {
  double farthest = 0.0;
  for (const Eigen::Vector3d& r : positions)
    farthest = std::max(farthest, (r - positions[0]).norm());
  return farthest;
}

// Why no scale aligns the two; empty where one does.
std::string no_scale(const Paths& paths) {
  constexpr double kRounding = 1e-6;  // of the true path: what is left of it is no shape
  const double of_truth = extent(paths.truth);
  if (paths.truth.size() < kFewestAligned) return "fewer than three poses";
  if (of_truth <= kAtRest) return "the true camera does not move";
  if (extent(paths.estimate) <= kRounding * of_truth) return "the estimate does not move";
  return "";
}

void add_aligned_errors(const std::vector<PosePair>& pairs, Accuracy& result) {
  const Paths paths = paths_of(pairs);
  result.sim3_reason = no_scale(paths);
  result.ate_se3 = result.ate_sim3 = result.scale = kUndefined;
  if (pairs.size() < kFewestAligned) return;
  const auto& [estimate, truth] = paths;
  const Similarity se3 = align(estimate, truth, AlignmentGroup::kSE3);
  result.ate_se3 = absolute_trajectory_error(estimate, truth, se3);
  if (!result.sim3_reason.empty()) return;
  const Similarity sim3 = align(estimate, truth, AlignmentGroup::kSim3);
  result.ate_sim3 = absolute_trajectory_error(estimate, truth, sim3);
  result.scale = sim3.scale;
}

}  // namespace

void Accuracy::forget_rotations() {
  rotation_rmse_deg = rotation_max_deg = kUndefined;
  relative_position_rmse = relative_scaled_rmse = relative_rotation_rmse_deg = kUndefined;
  over_tenths = over_kitti = {0, kUndefined, kUndefined, kUndefined};
}

double position_error(const PosePair& pair) {
  return (pair.truth.position - pair.estimate.state.position).norm();
}

double rotation_error_deg(const PosePair& pair) {
  const Eigen::Quaterniond relative =
      pair.estimate.state.orientation.conjugate() * pair.truth.orientation;
  return log_so3(relative).norm() * kDegrees;
}

Similarity similarity(const std::vector<PosePair>& pairs) {
  const Paths paths = paths_of(pairs);
  const AlignmentGroup group =
      no_scale(paths).empty() ? AlignmentGroup::kSim3 : AlignmentGroup::kSE3;
  return align(paths.estimate, paths.truth, group);
}

std::vector<PosePair> aligned(std::vector<PosePair> pairs) {
  const Similarity alignment = similarity(pairs);
  for (PosePair& pair : pairs) {
    pair.estimate.state.position = alignment * pair.estimate.state.position;
  }
  return pairs;
}

std::optional<int> failed_at(const std::vector<PosePair>& pairs, bool after_alignment) {
  constexpr double kFraction = 0.1, kOfExtent = 1.0 / 3.0, kMetre = 1.0;
  const auto [estimate, truth] = paths_of(after_alignment ? aligned(pairs) : pairs);
  std::vector<double> path(truth.size(), 0.0);
  for (std::size_t i = 1; i < truth.size(); ++i) {
    path[i] = path[i - 1] + (truth[i] - truth[i - 1]).norm();
  }
  const double room = extent(truth);
  for (std::size_t i = after_alignment ? 1 : 0; i < truth.size(); ++i) {
    const double whole = room > kAtRest ? kFraction * path.back() : kMetre;
    const double of_room = room > kAtRest ? kOfExtent * room : kMetre;
    const double allowed = after_alignment ? std::min(whole, of_room)
                                           : std::max(std::min(kMetre, whole), kFraction * path[i]);
    const double error = (truth[i] - estimate[i]).norm();
    if (error > std::max(allowed, kLeastFailure)) return pairs[i].frame;
  }
  return std::nullopt;
}

std::string failure_bound(bool after_alignment) {
  return after_alignment
             ? "a tenth of the path or a third of the largest distance from its start, after "
               "alignment"
             : "a tenth of the path so far, and a metre or a tenth of the whole path, "
               "whichever is less";
}

Accuracy accuracy(const std::vector<PosePair>& pairs, double relative_interval) {
  std::vector<double> positions, rotations;
  for (const PosePair& pair : pairs) {
    positions.push_back(position_error(pair));
    rotations.push_back(rotation_error_deg(pair));
  }
  Accuracy result;
  result.poses = static_cast<int>(pairs.size());
  result.position_rmse = root_mean_square(positions);
  result.position_max = maximum(positions);
  if (!positions.empty()) result.position_final = positions.back();
  result.rotation_rmse_deg = root_mean_square(rotations);
  result.rotation_max_deg = maximum(rotations);
  add_aligned_errors(pairs, result);
  add_relative_errors(pairs, relative_interval, result);
  add_path_errors(pairs, result);
  return result;
}

}  // namespace slammot
