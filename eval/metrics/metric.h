// The table of metrics. One row is one number of a finished run: from it come metrics.json, the
// table on the terminal, the scalars of a study (results.jsonl, summary.json), the columns of
// tables/metrics.csv and the tables of the reports. A new metric is one function and one row.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "datasets/sequence/sequence.h"
#include "eval/result/run_result.h"

namespace slammot {

struct RunMetrics;
struct TrajectoryMetrics;

// What a metric is computed from.
struct FinishedRun {
  const Sequence& sequence;
  const RunResult& run;
  const RunMetrics& metrics;  // what is computed once: accuracy, consistency, counts
  const TrajectoryMetrics&
      trajectory;  // the filtered one, that in the last scale, the smoothed one
  const std::vector<CameraEstimate>& estimates;  // of that trajectory
};

// A metric of a trajectory stands under `filtered`, of an estimator that smooths under `smoothed`,
// and where the scale is not known under `last_scale`.
enum class Scope { kRun, kTrajectory };

enum class Better { kSmaller, kLarger, kNearExpected, kNeither };

enum class Shown { kFiles, kPage, kTerminal };  // in files; on the page too; everywhere

enum class Form { kReal, kCount, kRatio };  // a ratio is shown in per cent

// How a study puts its runs together: into one number with its interval, or not at all.
enum class Pooled { kNot, kMean, kRootMeanSquare, kMedianTiming };

struct Metric {
  std::string key;      // as in a study, with `filtered_` or `smoothed_` before it: unique
  std::string unit;     // empty for a number without one
  std::string name;     // heads a column
  std::string caption;  // what it is, in a sentence
  std::function<double(const FinishedRun&)> value;  // NaN where it is not defined

  Scope scope = Scope::kRun;
  Form form = Form::kReal;
  int decimals = 3;
  Better better = Better::kSmaller;
  std::string expected = {};  // key of the metric that says what a consistent run has
  Shown shown = Shown::kFiles;
  Pooled pooled = Pooled::kMean;      // kMedianTiming: depends on the machine and the clock
  std::string block = {}, leaf = {};  // its place in metrics.json; by itself: `key` at the top

  const std::string& name_in_block() const { return leaf.empty() ? key : leaf; }
};

struct MetricValue {
  Metric metric;
  double value = 0.0;
};

using MetricTable = std::vector<Metric>;

// What a study compares its estimators by.
inline constexpr char kPositionRmse[] = "position_rmse_m";
inline constexpr char kAteSim3[] = "ate_sim3_m";  // where the truth is measured

// The metrics of this program.
const MetricTable& metric_table();

// For all that follows; throws std::invalid_argument for a key that is taken.
void add_metrics(const MetricTable& more);

// The same and more, for a caller that brings its own.
MetricTable metric_table_with(const MetricTable& more);

// The value of a metric; NaN if there is none of this key.
double value_of(const std::vector<MetricValue>& values, const std::string& key);

}  // namespace slammot
