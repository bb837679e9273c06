// Metrics of stored runs, also of runs made elsewhere, against a sequence.
#pragma once

#include <filesystem>
#include <optional>

#include "eval/output/metrics_table.h"

namespace slammot {

// Without `against`, the sequence is the one run.yaml names. Throws InputError.
NamedMetrics evaluate_run(const std::filesystem::path& folder,
                          const std::optional<std::filesystem::path>& against);

}  // namespace slammot
