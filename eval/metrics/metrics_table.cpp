#include "eval/metrics/metrics_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace slammot {
namespace {

using Cells = std::vector<std::string>;

std::string cell(double value, int significant) {
  if (std::isnan(value)) return "-";
  return fmt::format("{:.{}g}", value, significant);
}

std::string cell(const ClassCounts& counts) {
  return fmt::format("{}/{}/{}", counts.right, counts.wrong, counts.undecided);
}

Cells head() {
  return {"estimator",     "landmark model",    "position RMSE m", "rotation RMSE deg",
          "pose NEES (6)", "position NEES (3)", "NIS (2)",         "static r/w/u",
          "moving r/w/u",  "frames/s",          "state size",      "diverged"};
}

// A smoother's own trajectory is a row of its own below the filtered one.
Cells trajectory_row(const std::string& estimator, const std::string& landmark,
                     const TrajectoryMetrics& t) {
  Cells cells = {estimator, landmark};
  const auto& a = t.accuracy.value;
  const auto& c = t.consistency.value;
  cells.push_back(a ? fmt::format("{:.4f}", a->position_rmse) : "-");
  cells.push_back(a ? fmt::format("{:.4f}", a->rotation_rmse_deg) : "-");
  cells.push_back(c ? cell(c->pose.mean, 4) : "-");
  cells.push_back(c ? cell(c->position.mean, 4) : "-");
  return cells;
}

Cells filtered_row(const ComparedResult& r) {
  const RunMetrics& m = r.metrics;
  Cells cells = trajectory_row(r.estimator, r.landmark, m.filtered);
  cells.push_back(std::isnan(m.nis.mean) ? "-" : fmt::format("{:.3f}", m.nis.mean));
  cells.push_back(cell(m.classification.statics));
  cells.push_back(cell(m.classification.movings));
  cells.push_back(cell(m.runtime.frames_per_second, 4));
  cells.push_back(std::isnan(m.runtime.state_size_median)
                      ? "-"
                      : fmt::format("{:.0f}", m.runtime.state_size_median));
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

std::string metrics_table(const std::vector<ComparedResult>& results) {
  std::vector<Cells> rows = {head()};
  bool nis_known = false;
  for (const ComparedResult& result : results) {
    rows.push_back(filtered_row(result));
    nis_known = nis_known || !std::isnan(result.metrics.nis.mean);
    if (!result.metrics.smoothed) continue;
    rows.push_back(trajectory_row("  smoothed", "", *result.metrics.smoothed));
    rows.back().resize(rows.front().size());
  }
  std::string text = aligned(rows);
  if (nis_known) {
    text += fmt::format("NIS of accepted measurements; the gate lets {:.3f} be expected. ",
                        results.front().metrics.nis.expected);
  }
  return text + "r/w/u: right, wrong, undecided. NEES of one run: means, descriptive.\n";
}

}  // namespace slammot
