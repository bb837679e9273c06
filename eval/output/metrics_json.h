// metrics.json, and what other files share with it. What is not a number is null, an absent block
// is null beside `<block>_reason`.
#pragma once

#include <nlohmann/json.hpp>

#include "eval/metrics/metrics.h"

namespace slammot {

using Json = nlohmann::ordered_json;

Json metrics_json(const RunMetrics& metrics);

// The blocks of metrics.json that the other files of a run folder do not repeat: frames offered,
// measurement counts, NIS, smoothing time, divergence. For runs that are read back.
void restore_totals(const Json& metrics, RunResult& run);

// A whole number of an `int`'s range, not negative; throws a Json::exception for anything else.
int count_of(const Json& json);

// Each struct and back.
Json json_of(const MeasurementCounts& counts);
MeasurementCounts measurement_counts_of(const Json& json);
Json json_of(const std::optional<Divergence>& divergence);  // null: none
std::optional<Divergence> divergence_of(const Json& json);
Json json_of(const std::vector<RunWarning>& warnings);
std::vector<RunWarning> warnings_of(const Json& json);

// The values of the metrics for which `wanted` holds, by their keys.
Json values_json(const std::vector<MetricValue>& values,
                 const std::function<bool(const Metric&)>& wanted);

// The table of metrics without its functions, for the reports: what each key means.
Json metric_table_json(const MetricTable& table);

}  // namespace slammot
