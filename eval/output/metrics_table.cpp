#include "eval/output/metrics_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace slammot {
namespace {

using Cells = std::vector<std::string>;

std::string number(const Metric& metric, double value) {
  if (std::isnan(value)) return "-";
  if (metric.form == Form::kRatio) return fmt::format("{:.1f}%", 100.0 * value);
  const int decimals = metric.form == Form::kCount ? 0 : metric.decimals;
  return fmt::format("{:.{}f}", value, decimals);
}

std::string labels(const ClassCounts& counts) {
  return fmt::format("{}/{}/{}", counts.right, counts.wrong, counts.undecided);
}

// What a consistent run has is a number of the same run.
double expected_of(const Metric& metric, const RunMetrics& run) {
  const double of_run = value_of(run.values, metric.expected);
  return std::isnan(of_run) ? value_of(run.filtered.values, metric.expected) : of_run;
}

std::string heading(const Metric& metric, const RunMetrics& run) {
  const double expected = expected_of(metric, run);
  if (std::isnan(expected))
    return metric.unit.empty() ? metric.name : metric.name + " " + metric.unit;
  return fmt::format("{} ({:.4g})", metric.name, expected);
}

void add_numbers(Cells& cells, const std::vector<MetricValue>& values) {
  for (const MetricValue& v : values) {
    if (v.metric.shown == Shown::kTerminal) cells.push_back(number(v.metric, v.value));
  }
}

void add_headings(Cells& cells, const std::vector<MetricValue>& values, const RunMetrics& run) {
  for (const MetricValue& v : values) {
    if (v.metric.shown == Shown::kTerminal) cells.push_back(heading(v.metric, run));
  }
}

Cells head(const RunMetrics& run) {
  Cells cells = {"estimator", "landmark model"};
  add_headings(cells, run.filtered.values, run);
  add_headings(cells, run.values, run);
  for (const char* name : {"static r/w/u", "moving r/w/u", "warnings", "diverged"})
    cells.emplace_back(name);
  return cells;
}

// A smoother's own trajectory is a row of its own below the filtered one.
Cells trajectory_row(const std::string& estimator, const std::string& landmark,
                     const TrajectoryMetrics& t) {
  Cells cells = {estimator, landmark};
  add_numbers(cells, t.values);
  return cells;
}

Cells run_row(const NamedMetrics& r) {
  const RunMetrics& m = r.metrics;
  Cells cells = trajectory_row(r.estimator, r.landmark, m.filtered);
  add_numbers(cells, m.values);
  cells.push_back(labels(m.classification.statics));
  cells.push_back(labels(m.classification.movings));
  cells.push_back(m.warnings.empty() ? "none" : fmt::format("{}", m.warnings.size()));
  cells.push_back(m.diverged ? fmt::format("frame {}", m.diverged->frame) : "no");
  return cells;
}

std::string aligned(const std::vector<Cells>& rows) {
  std::vector<size_t> widths(rows.front().size(), 0);
  for (const Cells& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const Cells& row : rows) {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) {
      const bool left = i < 2;  // names to the left, numbers to the right
      line += left ? fmt::format("{:<{}}  ", row[i], widths[i])
                   : fmt::format("{:>{}}  ", row[i], widths[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

}  // namespace

std::string metrics_table(const std::vector<NamedMetrics>& results) {
  std::vector<Cells> rows = {head(results.front().metrics)};
  for (const NamedMetrics& result : results) {
    rows.push_back(run_row(result));
    if (!result.metrics.smoothed) continue;
    rows.push_back(trajectory_row("  smoothed", "", *result.metrics.smoothed));
    rows.back().resize(rows.front().size());
  }
  return aligned(rows) +
         "In parentheses: the mean of a consistent estimator; the gate cuts off the tail of the "
         "NIS. "
         "r/w/u: right, wrong, undecided.\nNEES of one run is a mean over correlated frames.\n";
}

}  // namespace slammot
