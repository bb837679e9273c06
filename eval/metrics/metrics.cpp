#include "eval/metrics/metrics.h"

#include "eval/statistics/chi_square.h"

namespace slammot {
namespace {

constexpr const char* kInexact = "truth is not exact";

bool all_have_covariances(const std::vector<PosePair>& pairs) {
  for (const PosePair& pair : pairs) {
    if (pair.estimate.covariance.topLeftCorner<6, 6>().hasNaN()) return false;
  }
  return true;
}

TrajectoryMetrics trajectory_metrics(const Sequence& sequence,
                                     const std::vector<CameraEstimate>& estimates) {
  TrajectoryMetrics metrics;
  const std::vector<PosePair> pairs = pair_with_truth(sequence, estimates);
  if (pairs.empty()) {
    metrics.accuracy.reason = metrics.consistency.reason = "no true pose";
    return metrics;
  }
  metrics.accuracy.value = accuracy(pairs);
  if (!sequence.exact_truth) {
    metrics.consistency.reason = kInexact;
  } else if (!all_have_covariances(pairs)) {
    metrics.consistency.reason = "no covariance of every pose";
  } else {
    metrics.consistency.value = pose_consistency(pairs);
  }
  return metrics;
}

void judge_landmarks(const Sequence& sequence, const RunResult& run, RunMetrics& metrics) {
  metrics.landmark_errors.reason = metrics.landmark_consistency.reason = "no true landmarks";
  if (sequence.landmarks.empty()) return;
  const LandmarkMetrics judged = landmark_metrics(sequence, run.landmarks);
  metrics.landmark_errors = {judged.errors, ""};
  metrics.landmark_consistency.reason = kInexact;
  if (sequence.exact_truth) metrics.landmark_consistency = {judged.consistency, ""};
}

Coverage coverage_of(const RunResult& run) {
  const FrameCounts& t = run.totals;
  return {.frames_offered = run.frames_offered,
          .frames_done = static_cast<int>(run.frames.size()),
          .offered = t.accepted + t.rejected + t.out_of_view,
          .accepted = t.accepted,
          .rejected = t.rejected,
          .out_of_view = t.out_of_view,
          .admitted = t.admitted,
          .lost = t.lost,
          .negative_inverse_depth = t.negative_inverse_depth};
}

}  // namespace

RunMetrics compute_metrics(const Sequence& sequence, const RunResult& run,
                           double gate_probability) {
  RunMetrics metrics;
  metrics.diverged = run.diverged;
  metrics.filtered = trajectory_metrics(sequence, run.filtered);
  if (!run.smoothed.empty()) metrics.smoothed = trajectory_metrics(sequence, run.smoothed);
  judge_landmarks(sequence, run, metrics);
  metrics.classification = classification_metrics(run.classification);
  metrics.nis.mean =
      run.totals.accepted == 0 ? kUndefined : run.totals.nis_sum / run.totals.accepted;
  metrics.nis.expected = gated_mean(gate_probability, metrics.nis.dof);
  metrics.coverage = coverage_of(run);
  metrics.runtime = runtime_metrics(run.timing, run.smoothing_ms);
  return metrics;
}

}  // namespace slammot
