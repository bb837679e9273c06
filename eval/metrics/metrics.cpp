#include "eval/metrics/metrics.h"

#include <algorithm>

#include "eval/metrics/true_rotations.h"
#include "eval/statistics/chi_square.h"

namespace slammot {
namespace {

constexpr const char* kInexact = "truth is not exact";

bool all_have_covariances(const std::vector<PosePair>& pairs) {
  for (const PosePair& pair : pairs) {
    const Matrix12d& P = pair.estimate.covariance;
    if (P.block<3, 3>(kPosition, kPosition).hasNaN()) return false;
    if (P.block<3, 3>(kRotation, kRotation).hasNaN()) return false;
  }
  return true;
}

// Of a run of this program on a truth that was simulated with its measurements.
bool is_trusted(const Sequence& sequence, const RunResult& run) {
  return sequence.exact_truth && run.in_force.has_value();
}

TrajectoryMetrics trajectory_metrics(const Sequence& sequence, const RunResult& run,
                                     const std::vector<CameraEstimate>& estimates) {
  TrajectoryMetrics metrics;
  if (estimates.empty()) {
    metrics.accuracy.reason = metrics.consistency.reason = "no pose was estimated";
    return metrics;
  }
  const std::vector<PosePair> pairs = pair_with_truth(sequence, estimates);
  if (pairs.empty()) {
    metrics.accuracy.reason = metrics.consistency.reason = "no true pose";
    return metrics;
  }
  const auto equal = equal_rotations(pairs, !sequence.exact_truth, is_trusted(sequence, run));
  metrics.accuracy.value = accuracy(pairs);
  if (equal && equal->not_judged) metrics.accuracy.value->forget_rotations();
  if (!sequence.exact_truth) {
    metrics.consistency.reason = kInexact;
  } else if (!all_have_covariances(pairs)) {
    metrics.consistency.reason = "not every pose has a covariance";
  } else {
    metrics.consistency.value = pose_consistency(pairs);
    if (equal && equal->not_judged) metrics.consistency.value->forget_rotations();
  }
  return metrics;
}

// Every lag, 0 being the filter, is judged over the same frames: all but the last ones, which the
// longest lag does not reach. An error that grows would make a long lag look better than it is.
std::map<int, TrajectoryMetrics> by_lag(const Sequence& sequence, const RunResult& run) {
  std::map<int, TrajectoryMetrics> metrics;
  constexpr auto kLongest = static_cast<std::size_t>(*std::ranges::max_element(kLags));
  if (run.lagged.empty() || run.filtered.size() <= kLongest) return metrics;
  const std::size_t judged = run.filtered.size() - kLongest;
  const auto judge = [&](std::vector<CameraEstimate> poses) {
    poses.resize(std::min(poses.size(), judged));
    return trajectory_metrics(sequence, run, poses);
  };
  metrics[0] = judge(run.filtered);
  for (const auto& [lag, poses] : run.lagged) metrics[lag] = judge(poses);
  return metrics;
}

void judge_trajectories(const Sequence& sequence, const RunResult& run, RunMetrics& metrics) {
  metrics.filtered = trajectory_metrics(sequence, run, run.filtered);
  if (run.batch || !run.smoothed.empty()) {
    metrics.smoothed = trajectory_metrics(sequence, run, run.smoothed);
  }
  if (!run.last_scale.empty()) {
    metrics.last_scale = trajectory_metrics(sequence, run, run.last_scale);
  }
  if (!run.batch) metrics.lagged = by_lag(sequence, run);  // of a batch: its front window's
}

void judge_landmarks(const Sequence& sequence, const RunResult& run, RunMetrics& metrics) {
  metrics.landmark_errors.reason = metrics.landmark_consistency.reason = "no true landmarks";
  if (sequence.landmarks.empty()) return;
  if (run.landmarks.empty() && !run.in_force) {  // of one made elsewhere
    metrics.landmark_errors.reason = metrics.landmark_consistency.reason = "no estimated landmarks";
    return;
  }
  const LandmarkMetrics judged = landmark_metrics(sequence, run.landmarks);
  metrics.landmark_errors = {judged.errors, ""};
  metrics.landmark_consistency.reason = kInexact;
  if (sequence.exact_truth) metrics.landmark_consistency = {judged.consistency, ""};
}

MeasurementCounts measurement_counts(const RunResult& run) {
  const FrameCounts& t = run.totals;
  return {.frames_offered = run.frames_offered,
          .frames_done = static_cast<int>(run.frames.size()),
          .offered = t.accepted + t.rejected + t.out_of_view,
          .accepted = t.accepted,
          .rejected = t.rejected,
          .out_of_view = t.out_of_view,
          .initialised = t.admitted,
          .pruned = t.pruned,
          .negative_inverse_depth = t.negative_inverse_depth};
}

std::vector<MetricValue> values_of(const MetricTable& table, Scope scope,
                                   const FinishedRun& finished) {
  std::vector<MetricValue> values;
  for (const Metric& metric : table) {
    if (metric.scope == scope) values.push_back({metric, metric.value(finished)});
  }
  return values;
}

// The blocks are complete here: a row may look at any of them.
void evaluate_table(const MetricTable& table, const Sequence& sequence, const RunResult& run,
                    RunMetrics& metrics) {
  const FinishedRun filtered{sequence, run, metrics, metrics.filtered, run.filtered};
  metrics.filtered.values = values_of(table, Scope::kTrajectory, filtered);
  if (metrics.smoothed) {
    const FinishedRun smoothed{sequence, run, metrics, *metrics.smoothed, run.smoothed};
    metrics.smoothed->values = values_of(table, Scope::kTrajectory, smoothed);
  }
  if (metrics.last_scale) {
    const FinishedRun shape{sequence, run, metrics, *metrics.last_scale, run.last_scale};
    metrics.last_scale->values = values_of(table, Scope::kTrajectory, shape);
  }
  metrics.values = values_of(table, Scope::kRun, filtered);
}

}  // namespace

namespace {

// A run that has a pose of few frames has failed, however good these are: at the last of them.
std::optional<int> without_poses(const Sequence& sequence, const std::vector<CameraEstimate>& run) {
  if (!covers_few(run.size(), sequence.frames.size())) return std::nullopt;
  const auto after =
      std::ranges::upper_bound(sequence.frames, run.back().timestamp, {}, &Frame::timestamp);
  return (after == sequence.frames.end() ? sequence.frames.back() : *after).index;
}

}  // namespace

RunMetrics compute_metrics(const Sequence& sequence, const RunResult& run, double gate_probability,
                           const MetricTable& table) {
  RunMetrics metrics;
  metrics.diverged = run.diverged;
  metrics.warnings = run.warnings;
  metrics.in_force = run.in_force;
  metrics.alignment = run.alignment;
  metrics.batch = run.batch;
  judge_trajectories(sequence, run, metrics);
  const std::vector<PosePair> judged = pair_with_truth(sequence, run.judged());
  metrics.failed = failed_at(judged, !sequence.exact_truth);
  if (!metrics.failed && !run.diverged && !judged.empty()) {
    metrics.failed = without_poses(sequence, run.judged());
  }
  if (const auto equal =
          equal_rotations(judged, !sequence.exact_truth, is_trusted(sequence, run))) {
    const auto said = [&](const RunWarning& warning) { return warning.reason == equal->reason; };
    if (std::ranges::none_of(run.warnings, said)) {
      metrics.warnings.insert(metrics.warnings.begin(), {std::nullopt, equal->reason});
    }
  }
  judge_landmarks(sequence, run, metrics);
  metrics.classification = classification_metrics(run.classification);
  const auto per_accepted = [&](double sum) {
    return run.totals.accepted == 0 ? kUndefined : sum / run.totals.accepted;
  };
  metrics.nis.mean = per_accepted(run.totals.nis_sum);
  metrics.nis.joint_mean = per_accepted(run.totals.joint_nis);
  metrics.nis.lasting_sums = run.totals.lasting_sums;
  if (run.totals.lasting_sums > 0) {
    metrics.nis.lasting_mean = run.totals.lasting_nis / run.totals.lasting_sums;
  }
  metrics.nis.expected = gated_mean(gate_probability, metrics.nis.dof);
  metrics.measurements = measurement_counts(run);
  metrics.runtime = runtime_metrics(run.timing, run.smoothing_ms, run.batch);
  evaluate_table(table, sequence, run, metrics);
  return metrics;
}

}  // namespace slammot
