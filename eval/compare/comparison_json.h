// The parts of compare.json that runs made now and runs read back have in common; compare.h gives
// the fields.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "eval/metrics/metrics.h"
#include "eval/output/metrics_json.h"

namespace slammot {

// What a run is called and how it was made.
struct ComparedEntry {
  std::string label;  // also the name of its folder
  std::string estimator;
  std::string kind;  // as to_string(EstimatorKind), or `foreign`
  bool oracle = false;
  std::string landmark;
  std::map<std::string, std::string> overrides;
  std::vector<std::pair<std::string, std::string>> configuration;
};

Json sequence_json(const Sequence& sequence, std::optional<std::uint64_t> seed);

Json run_json(const Sequence& sequence, const ComparedEntry& entry, const RunResult& run,
              const RunMetrics& metrics);

// The whole, without a run.
Json comparison_json(const std::string& command, const Sequence& sequence,
                     std::optional<std::uint64_t> seed, const MetricTable& metrics);

}  // namespace slammot
