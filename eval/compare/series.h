// What a report draws against time, decimated, as JSON; see compare.h for the fields.
#pragma once

#include <nlohmann/json.hpp>

#include "datasets/sequence/sequence.h"
#include "eval/metrics/metrics.h"
#include "eval/result/run_result.h"

namespace slammot {

// Of the trajectory that the run is judged by.
nlohmann::ordered_json run_series(const Sequence& sequence, const RunResult& run,
                                  const TrajectoryMetrics& metrics);
// Of another one of the run.
nlohmann::ordered_json path_series(const Sequence& sequence,
                                   const std::vector<CameraEstimate>& estimates,
                                   const TrajectoryMetrics& metrics);
nlohmann::ordered_json truth_json(const Sequence& sequence);

}  // namespace slammot
