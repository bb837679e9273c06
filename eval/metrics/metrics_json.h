// metrics.json. What is not a number is null, an absent block is null beside `<block>_reason`.
#pragma once

#include <nlohmann/json.hpp>

#include "eval/metrics/metrics.h"

namespace slammot {

nlohmann::ordered_json metrics_json(const RunMetrics& metrics);

// The blocks of metrics.json that the other files of a run folder do not repeat: frames offered,
// measurement counts, NIS, smoothing time, divergence. For runs that are read back.
void restore_totals(const nlohmann::ordered_json& metrics, RunResult& run);

}  // namespace slammot
