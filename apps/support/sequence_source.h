// Where a command's sequence comes from: a folder, or a scenario that is simulated.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/configuration.h"

namespace slammot {

struct ScenarioOptions {
  std::string scenario;
  std::uint64_t seed = 1;
  std::vector<std::string> settings;
};

// `settings` as keys and values.
ScenarioOverrides overrides_of(const ScenarioOptions& options);

// Simulates, writes the sequence to `folder` and reads it back, so that what is run is what is
// stored.
Sequence simulate_to(const ScenarioOptions& options, const std::filesystem::path& folder);

}  // namespace slammot
