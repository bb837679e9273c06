// Simulated sequences by name. One file and one row add a scenario.
//
// Same scenario, overrides and seed: the same bytes. Frames: W with y down, camera x right, y down,
// z forward; metres, radians, seconds, pixels.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "datasets/sequence/sequence.h"
#include "datasets/simulation/parameters/parameters.h"

namespace slammot {

struct ScenarioRow {
  std::string_view name;
  std::string_view description;
  Sequence (*simulate)(std::string_view name, const ScenarioOverrides& overrides,
                       std::uint64_t seed);
  std::vector<ScenarioParameter> (*parameters)();
  // Throws what simulate() would of the overrides; null: only simulate() itself can say.
  void (*check)(std::string_view name, const ScenarioOverrides& overrides,
                std::uint64_t seed) = nullptr;
};
std::span<const ScenarioRow> scenario_table();

// With their defaults. Throws std::invalid_argument for an unknown scenario.
std::vector<ScenarioParameter> scenario_parameters(std::string_view scenario);

// A scenario is its options, their parameters(options) and a function of options and seed.
template <typename Options, Sequence (*Run)(const Options&, std::uint64_t)>
constexpr ScenarioRow scenario_row(std::string_view name, std::string_view description) {
  return {name, description,
          [](std::string_view scenario, const ScenarioOverrides& overrides, std::uint64_t seed) {
            Options options;
            apply(overrides, scenario, parameters(options));
            return Run(options, seed);
          },
          [] {
            Options options;
            return describe(parameters(options));
          },
          nullptr};
}

// Throws std::invalid_argument for a name that is taken.
void add_scenarios(std::span<const ScenarioRow> rows);

// Throws std::invalid_argument for an unknown scenario or key, or a value that is not allowed. The
// truth carries the exact velocities.
Sequence simulate(std::string_view scenario, const ScenarioOverrides& overrides,
                  std::uint64_t seed);

// Throws as simulate() does. Where that renders for minutes, without rendering.
void check_scenario(std::string_view scenario, const ScenarioOverrides& overrides,
                    std::uint64_t seed);

}  // namespace slammot
