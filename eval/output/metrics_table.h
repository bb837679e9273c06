// Runs side by side as aligned text: the metrics of their trajectories and whether they failed or
// diverged; below, their other metrics and labels. `-` where a metric is not known.
#pragma once

#include <string>
#include <vector>

#include "eval/metrics/metrics.h"

namespace slammot {

struct NamedMetrics {
  std::string label;
  std::string estimator;
  std::string landmark;
  RunMetrics metrics;
  std::string sequence = {};  // shown where it is not that of all
};

// Columns to their width, the first `names` to the left and numbers to the right.
using TextRow = std::vector<std::string>;
std::string aligned(const std::vector<TextRow>& rows, std::size_t names);

// `, from frame 7: REASON`
std::string told(const RunWarning& warning);

// A line for each warning of each run; empty without any.
std::string warning_lines(const std::vector<NamedMetrics>& results);

std::string metrics_table(const std::vector<NamedMetrics>& results);

}  // namespace slammot
