#include "datasets/simulation/scenario.h"

#include <fmt/format.h>

#include "datasets/simulation/circle.h"
#include "datasets/simulation/helix.h"
#include "datasets/simulation/manoeuvres.h"
#include "datasets/simulation/matched.h"
#include "datasets/simulation/move_stop_move.h"
#include "datasets/simulation/parameters/parameters.h"
#include "datasets/simulation/square.h"
#include "models/find_row.h"

namespace slammot {
namespace {

constexpr ScenarioRow kScenarios[] = {
    scenario_row<CircleOptions, simulate_circle>(
        "circle", "one loop and a third at a speed that is never constant (thesis 4.1a)"),
    scenario_row<SquareOptions, simulate_square>(
        "square", "four connected lines at constant speed (thesis 4.1b)"),
    scenario_row<HelixOptions, simulate_helix>(
        "helix", "39 known points, one static target, two movers (thesis 3.1)"),
    scenario_row<HelixOptions, simulate_helix_unobservable>(
        "helix_unobservable", "the same from a camera at constant velocity (thesis 3.1.4)"),
    scenario_row<MoveStopMoveOptions, simulate_move_stop_move>(
        "move_stop_move", "the circle with objects that stop and go, and some parked at first"),
    scenario_row<ManoeuvresOptions, simulate_manoeuvres>(
        "manoeuvres", "the circle with movers half of which turn and brake all the time"),
    scenario_row<MatchedOptions, simulate_matched>(
        "model_matched", "everything drawn from the models themselves, to calibrate consistency"),
};

std::vector<ScenarioRow>& table() {
  static std::vector<ScenarioRow> rows(std::begin(kScenarios), std::end(kScenarios));
  return rows;
}

}  // namespace

std::span<const ScenarioRow> scenario_table() { return table(); }

void add_scenarios(std::span<const ScenarioRow> rows) { add_rows(table(), rows, "scenario"); }

namespace {

const ScenarioRow& find_scenario(std::string_view name) {
  if (name == "matched") name = "model_matched";  // its name until release 0.1
  return find_row(scenario_table(), name, "scenario");
}

}  // namespace

std::vector<ScenarioParameter> scenario_parameters(std::string_view scenario) {
  return find_scenario(scenario).parameters();
}

Sequence simulate(std::string_view scenario, const ScenarioOverrides& overrides,
                  std::uint64_t seed) {
  const ScenarioRow& row = find_scenario(scenario);
  Sequence sequence = row.simulate(row.name, overrides, seed);
  sequence.name = fmt::format("{}-{}", row.name, seed);
  return sequence;
}

void check_scenario(std::string_view scenario, const ScenarioOverrides& overrides,
                    std::uint64_t seed) {
  const ScenarioRow& row = find_scenario(scenario);
  if (row.check) {
    row.check(row.name, overrides, seed);
  } else {
    row.simulate(row.name, overrides, seed);
  }
}

}  // namespace slammot
