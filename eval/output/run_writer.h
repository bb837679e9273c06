// Writes the Run folder of FORMATS.md, and the files run_reader.h reads back. Numbers have 17
// significant digits; what is not defined is `nan` in CSV and null in JSON, never 0.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "eval/configuration/configuration.h"
#include "eval/metrics/metrics.h"
#include "eval/provenance/provenance.h"
#include "eval/result/run_result.h"

namespace slammot {

// What run.yaml says beside the configuration: enough to repeat the run.
struct RunDescription {
  std::string command;
  std::string estimator;
  std::filesystem::path sequence;
  std::string sequence_name;
  std::string sequence_sha256;
  std::optional<std::uint64_t> seed;            // of a simulated sequence
  Configuration configuration;                  // the effective one
  std::vector<std::string> from_sequence = {};  // its keys whose value the sequence decided
  Provenance made_by = provenance();
};

// All files or none. Replaces an earlier run: ask require_output() first.
void write_run(const std::filesystem::path& folder, const RunDescription& description,
               const RunResult& run, const RunMetrics& metrics);

// All files but run.yaml.
void write_results(const std::filesystem::path& folder, const RunResult& run,
                   const RunMetrics& metrics);

}  // namespace slammot
