// Runs side by side as one aligned text table: the metrics shown on the terminal, the
// labels and whether a run diverged. `-` where a metric is not known.
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
};

std::string metrics_table(const std::vector<NamedMetrics>& results);

}  // namespace slammot
