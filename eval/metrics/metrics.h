// What is computed once of a finished run, and the value of every row of the table of metrics.
//
// What cannot be known is absent, with a reason: accuracy without truth, NEES without exact truth
// (NEES against a measured truth measures the truth as well) or without a covariance.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "datasets/sequence/sequence.h"
#include "eval/metrics/accuracy.h"
#include "eval/metrics/labels/classification_table.h"
#include "eval/metrics/landmark_metrics.h"
#include "eval/metrics/metric.h"
#include "eval/metrics/nees.h"
#include "eval/metrics/runtime.h"
#include "eval/result/run_result.h"

namespace slammot {

template <typename T>
struct Known {
  std::optional<T> value;
  std::string reason;  // why there is none
};

struct TrajectoryMetrics {
  Known<Accuracy> accuracy;
  Known<PoseConsistency> consistency;
  std::vector<MetricValue> values;
};

struct NisMetrics {
  int dof = 2;
  double mean = 0.0;      // of the accepted measurements
  double expected = 0.0;  // of a consistent filter, given that the gate cuts the tail off
  // Of all accepted of a frame together, over their number: what they share counts once. 2 is
  // right.
  double joint_mean = 0.0;
  int lasting_sums = 0;
  // Of sums of thirty innovations of a track (lasting_errors.h): 2 where they are independent.
  double lasting_mean = kUndefined;
};

struct MeasurementCounts {
  int frames_offered = 0;
  int frames_done = 0;
  int offered = 0;  // measurements of landmarks in the state: accepted + rejected + out of view
  int accepted = 0;
  int rejected = 0;
  int out_of_view = 0;
  int initialised = 0;             // landmarks
  int pruned = 0;                  // landmarks
  int negative_inverse_depth = 0;  // sum over the frames
};

struct RunMetrics {
  std::optional<Divergence> diverged;
  std::vector<RunWarning> warnings;
  std::optional<InForce> in_force;  // see RunResult
  std::optional<RunAlignment> alignment;
  std::optional<int> failed;  // the first frame that failed, see failed_at()
  TrajectoryMetrics filtered;
  std::optional<TrajectoryMetrics> smoothed;    // of an estimator that smooths
  std::optional<TrajectoryMetrics> last_scale;  // where the scale is not known, see RunResult
  bool batch = false;                           // see RunResult
  std::map<int, TrajectoryMetrics> lagged;      // by lag, of one that keeps past poses
  Known<LandmarkErrors> landmark_errors;
  Known<LandmarkConsistency> landmark_consistency;
  ClassificationMetrics classification;
  NisMetrics nis;
  MeasurementCounts measurements;
  RuntimeMetrics runtime;
  std::vector<MetricValue> values;

  bool warned() const { return diverged || !warnings.empty(); }
  const TrajectoryMetrics& judged() const { return batch ? *smoothed : filtered; }
};

RunMetrics compute_metrics(const Sequence& sequence, const RunResult& run, double gate_probability,
                           const MetricTable& table = metric_table());

}  // namespace slammot
