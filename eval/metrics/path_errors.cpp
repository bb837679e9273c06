#include "eval/metrics/path_errors.h"

#include <algorithm>
#include <numbers>

#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

std::vector<double> distances_along(const std::vector<PosePair>& pairs) {
  std::vector<double> along(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    along[i] = along[i - 1] + (pairs[i].truth.position - pairs[i - 1].truth.position).norm();
  }
  return along;
}

// Of b seen from a.
Eigen::Vector3d displacement(const CameraState& a, const CameraState& b) {
  return a.orientation.conjugate() * (b.position - a.position);
}

// The error of the displacement, in the true frame at its end; only its length counts.
double translation_error(const PosePair& a, const PosePair& b, double scale) {
  const Eigen::Vector3d truth = displacement(a.truth, b.truth);
  return (truth - scale * displacement(a.estimate.state, b.estimate.state)).norm();
}

double turn_error_deg(const PosePair& a, const PosePair& b) {
  const Eigen::Quaterniond truth = a.truth.orientation.conjugate() * b.truth.orientation;
  const Eigen::Quaterniond estimate =
      a.estimate.state.orientation.conjugate() * b.estimate.state.orientation;
  return log_so3(Eigen::Quaterniond(truth.conjugate() * estimate)).norm() * 180.0 /
         std::numbers::pi;
}

double spread(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p / static_cast<double>(points.size());
  std::vector<double> distances;
  for (const Eigen::Vector3d& p : points) distances.push_back((p - mean).norm());
  return root_mean_square(distances);
}

}  // namespace

DistanceErrors distance_errors(const std::vector<PosePair>& pairs, std::span<const double> lengths,
                               int step, double scale) {
  const std::vector<double> along = distances_along(pairs);
  std::vector<double> translation, scaled, rotation;
  for (std::size_t i = 0; i < pairs.size(); i += static_cast<std::size_t>(step)) {
    for (const double length : lengths) {
      const auto end = std::ranges::upper_bound(along, along[i] + length);
      if (end == along.end() || !(length > 0.0)) continue;
      const PosePair& last = pairs[static_cast<std::size_t>(end - along.begin())];
      translation.push_back(100.0 * translation_error(pairs[i], last, 1.0) / length);
      scaled.push_back(100.0 * translation_error(pairs[i], last, scale) / length);
      rotation.push_back(turn_error_deg(pairs[i], last) / length);
    }
  }
  return {static_cast<int>(translation.size()), mean(translation), mean(scaled), mean(rotation)};
}

double true_path_length(const std::vector<PosePair>& pairs) {
  return pairs.empty() ? 0.0 : distances_along(pairs).back();
}

std::array<double, kTenths> scale_along_path(const std::vector<PosePair>& pairs) {
  constexpr double kAtRestWithin = 1e-3;  // [m]
  std::array<std::vector<Eigen::Vector3d>, kTenths> estimate, truth;
  const std::vector<double> along = distances_along(pairs);
  for (std::size_t i = 0; i < pairs.size() && along.back() > 0.0; ++i) {
    const auto tenth = static_cast<std::size_t>(kTenths * along[i] / along.back());
    estimate[std::min(tenth, kTenths - 1)].push_back(pairs[i].estimate.state.position);
    truth[std::min(tenth, kTenths - 1)].push_back(pairs[i].truth.position);
  }
  std::array<double, kTenths> scales;
  for (std::size_t k = 0; k < kTenths; ++k) {
    const bool known = truth[k].size() >= 3 && spread(truth[k]) > kAtRestWithin;
    scales[k] = known ? spread(estimate[k]) / spread(truth[k]) : kUndefined;
  }
  return scales;
}

}  // namespace slammot
