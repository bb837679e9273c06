#include "eval/output/metrics_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "datasets/text/printable.h"

namespace slammot {
namespace {

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

// With what a consistent run has, where that is the same for all of which it is known.
std::string heading(const Metric& metric, const std::vector<NamedMetrics>& results) {
  std::set<double> expected;
  for (const NamedMetrics& r : results) {
    const double of_run = expected_of(metric, r.metrics);
    if (!std::isnan(of_run)) expected.insert(of_run);
  }
  if (expected.size() != 1)
    return metric.unit.empty() ? metric.name : metric.name + " " + metric.unit;
  return fmt::format("{} ({:.4g})", metric.name, *expected.begin());
}

void add_numbers(TextRow& cells, const std::vector<MetricValue>& values) {
  for (const MetricValue& v : values) {
    if (v.metric.shown == Shown::kTerminal) cells.push_back(number(v.metric, v.value));
  }
}

void add_headings(TextRow& cells, const std::vector<MetricValue>& values,
                  const std::vector<NamedMetrics>& results) {
  for (const MetricValue& v : values) {
    if (v.metric.shown == Shown::kTerminal) cells.push_back(heading(v.metric, results));
  }
}

// Each row begins with the run's names.
using Names = std::vector<TextRow>;

// The name of a run's folder, unless it says no more than estimator and landmark model do.
Names names_of(const std::vector<NamedMetrics>& results) {
  const bool labelled = std::ranges::any_of(
      results, [](const auto& r) { return r.label != r.estimator + "-" + r.landmark; });
  const bool several = std::ranges::any_of(
      results, [&](const auto& r) { return r.sequence != results.front().sequence; });
  Names names = {{"estimator", "landmark model"}};
  for (const NamedMetrics& r : results) names.push_back({r.estimator, r.landmark});
  if (several) {
    names.front().emplace_back("sequence");
    for (std::size_t i = 0; i < results.size(); ++i) {
      names[i + 1].push_back(printable(results[i].sequence));
    }
  }
  if (!labelled) return names;
  names.front().insert(names.front().begin(), "run");
  for (std::size_t i = 0; i < results.size(); ++i) {
    names[i + 1].insert(names[i + 1].begin(), results[i].label);
  }
  return names;
}

std::string at_frame(const std::optional<int>& frame) {
  return frame ? fmt::format("frame {}", *frame) : "no";
}

// What a run has beside the trajectory that it is judged by is a row of its own below it.
std::vector<TextRow> trajectory_rows(const Names& names, const std::vector<NamedMetrics>& results) {
  std::vector<TextRow> rows = {names.front()};
  add_headings(rows[0], results[0].metrics.filtered.values, results);
  for (const char* name : {"failed", "diverged"}) rows[0].emplace_back(name);
  const auto add_below = [&](const char* name, std::size_t left, const TrajectoryMetrics& other) {
    TextRow& row = rows.emplace_back(left);
    row.front() = name;
    add_numbers(row, other.values);
    row.resize(rows.front().size());
  };
  for (std::size_t i = 0; i < results.size(); ++i) {
    const RunMetrics& m = results[i].metrics;
    TextRow& row = rows.emplace_back(names[i + 1]);
    add_numbers(row, m.judged().values);
    row.push_back(m.judged().accuracy.value ? at_frame(m.failed) : "-");
    row.push_back(at_frame(m.diverged ? std::optional(m.diverged->frame) : std::nullopt));
    const std::size_t left = names[i + 1].size();
    if (m.last_scale) add_below("  in the last scale", left, *m.last_scale);
    if (m.smoothed && !m.batch) add_below("  smoothed", left, *m.smoothed);
  }
  return rows;
}

// What only an estimator of this program tells: none of a trajectory made elsewhere.
std::vector<TextRow> run_rows(const Names& names, const std::vector<NamedMetrics>& results) {
  std::vector<TextRow> rows = {names.front()};
  add_headings(rows[0], results[0].metrics.values, results);
  for (const char* name : {"static r/w/u", "moving r/w/u", "warnings"}) rows[0].emplace_back(name);
  for (std::size_t i = 0; i < results.size(); ++i) {
    const RunMetrics& m = results[i].metrics;
    if (m.runtime.stages.empty() && m.measurements.offered == 0) continue;
    TextRow& row = rows.emplace_back(names[i + 1]);
    add_numbers(row, m.values);
    row.push_back(labels(m.classification.statics));
    row.push_back(labels(m.classification.movings));
    row.push_back(m.warnings.empty() ? "none" : fmt::format("{}", m.warnings.size()));
  }
  return rows;
}

// Why there are dashes: a line for each reason.
std::string reasons(const std::vector<NamedMetrics>& results) {
  std::map<std::string, std::string> labels_of;
  for (const NamedMetrics& r : results) {
    const TrajectoryMetrics& judged = r.metrics.judged();
    const bool no_accuracy = !judged.accuracy.value;
    if (!no_accuracy && judged.consistency.value) continue;
    const std::string reason = no_accuracy ? "No accuracy (" + judged.accuracy.reason + "): "
                                           : "No NEES (" + judged.consistency.reason + "): ";
    std::string& labels = labels_of[reason];
    labels += (labels.empty() ? "" : ", ") + r.label;
  }
  std::string text;
  for (const auto& [reason, labels] : labels_of) text += reason + labels + ".\n";
  return text;
}

// How runs were aligned: a line for each way.
std::string alignments(const std::vector<NamedMetrics>& results) {
  std::map<std::string, std::string> labels_of;
  for (const NamedMetrics& r : results) {
    if (!r.metrics.alignment) continue;
    std::string& labels = labels_of[r.metrics.alignment->note];
    labels += (labels.empty() ? "" : ", ") + r.label;
  }
  std::string text;
  for (const auto& [note, labels] : labels_of) text += fmt::format("{}: {}.\n", labels, note);
  return text;
}

}  // namespace

std::string aligned(const std::vector<TextRow>& rows, std::size_t names) {
  std::vector<size_t> widths(rows.front().size(), 0);
  for (const TextRow& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const TextRow& row : rows) {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) {
      const bool left = i < names;  // names to the left, numbers to the right
      line += left ? fmt::format("{:<{}}  ", row[i], widths[i])
                   : fmt::format("{:>{}}  ", row[i], widths[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string told(const RunWarning& w) {
  return (w.frame ? fmt::format(", from frame {}: ", *w.frame) : ": ") + w.reason;
}

std::string warning_lines(const std::vector<NamedMetrics>& results) {
  std::string text;
  for (const NamedMetrics& result : results) {
    for (const RunWarning& w : result.metrics.warnings) {
      text += "slammot: warning: " + printable(result.label + told(w)) + "\n";
    }
  }
  return text;
}

std::string metrics_table(const std::vector<NamedMetrics>& results) {
  const Names names = names_of(results);
  const std::size_t left = names.front().size();
  const std::vector<TextRow> of_trajectories = trajectory_rows(names, results);
  std::string text = aligned(of_trajectories, left);
  const std::vector<TextRow> of_runs = run_rows(names, results);
  const bool own = of_runs.size() > 1;
  if (own) text += "\n" + aligned(of_runs, left);
  const auto has = [](const TextRow& head, auto is) { return std::ranges::any_of(head, is); };
  const auto expects = [](const char* name) {
    return [=](const std::string& h) { return h.find(name) != std::string::npos; };
  };
  const bool nees = has(of_trajectories.front(), expects("NEES ("));
  const bool nis = own && has(of_runs.front(), expects("NIS ("));
  text += alignments(results) + reasons(results);
  if (nees || nis) text += "In parentheses: the mean of a consistent estimator.\n";
  if (nees) {
    text += "NEES of one run is a mean over correlated frames, without the first.\n";
  }
  if (own) {
    text += "The gate cuts off the tail of the NIS. r/w/u: right, wrong, undecided.\n";
  }
  return text + "Failed: the error exceeds " + failure_bound(false) +
         "; where the\ntruth is measured, " + failure_bound(true) + ".\n";
}

}  // namespace slammot
