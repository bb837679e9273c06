#include "eval/metrics/nees.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "eval/statistics/chi_square.h"
#include "eval/statistics/statistics.h"

namespace slammot {

bool is_positive_definite(const Eigen::MatrixXd& covariance) {
  if (!covariance.allFinite()) return false;
  return Eigen::LLT<Eigen::MatrixXd>(covariance).info() == Eigen::Success;
}

double nees(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  constexpr double kFailure = std::numeric_limits<double>::infinity();
  if (!error.allFinite() || !covariance.allFinite()) return kFailure;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(covariance);
  if (cholesky.info() != Eigen::Success) return kFailure;
  const double value = cholesky.matrixL().solve(error).squaredNorm();
  return std::isfinite(value) ? value : kFailure;
}

double nees_if_defined(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  return error.hasNaN() || covariance.hasNaN() ? kUndefined : nees(error, covariance);
}

namespace {

NeesSummary undefined(int dof) {
  NeesSummary s;
  s.dof = dof;
  s.mean = s.median = s.q95 = s.interval_coverage = kUndefined;
  const Interval interval = nees_interval(dof);
  s.lower = interval.lower;
  s.upper = interval.upper;
  return s;
}

}  // namespace

NeesSummary summarise_nees(const std::vector<double>& samples, int dof) {
  const Interval interval = nees_interval(dof);
  NeesSummary s;
  s.dof = dof;
  if (std::ranges::any_of(samples, [](double x) { return std::isnan(x); })) return undefined(dof);
  s.used = static_cast<int>(samples.size());
  int covered = 0;
  for (const double x : samples) {
    s.failures += std::isfinite(x) ? 0 : 1;
    covered += x >= interval.lower && x <= interval.upper ? 1 : 0;
  }
  s.mean = mean(samples);
  s.median = median(samples);
  s.q95 = quantile(samples, 0.95);
  s.lower = interval.lower;
  s.upper = interval.upper;
  s.interval_coverage = s.used == 0 ? std::numeric_limits<double>::quiet_NaN()
                                    : static_cast<double>(covered) / static_cast<double>(s.used);
  return s;
}

PoseNees pose_nees(const PosePair& pair) {
  const Vector12d error = boxminus(pair.truth, pair.estimate.state);
  const Matrix12d& P = pair.estimate.covariance;
  const auto of_block = [&](int first, int size) {
    return nees_if_defined(error.segment(first, size), P.block(first, first, size, size));
  };
  return {pair.frame, pair.estimate.timestamp, of_block(kPosition, 6), of_block(kPosition, 3),
          of_block(kRotation, 3)};
}

void PoseConsistency::forget_rotations() {
  pose = undefined(pose.dof);
  rotation = undefined(rotation.dof);
  for (PoseNees& sample : series) sample.pose = sample.rotation = kUndefined;
}

PoseConsistency pose_consistency(const std::vector<PosePair>& pairs) {
  PoseConsistency result;
  std::vector<double> pose, position, rotation;
  for (size_t i = 1; i < pairs.size(); ++i) {
    const PoseNees sample = pose_nees(pairs[i]);
    pose.push_back(sample.pose);
    position.push_back(sample.position);
    rotation.push_back(sample.rotation);
    result.series.push_back(sample);
  }
  result.pose = summarise_nees(pose, 6);
  result.position = summarise_nees(position, 3);
  result.rotation = summarise_nees(rotation, 3);
  return result;
}

}  // namespace slammot
