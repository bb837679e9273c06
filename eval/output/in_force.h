// What of the method acted in a run (estimation/in_force.h), in files and on the terminal.
#pragma once

#include <string>
#include <vector>

#include "eval/output/metrics_json.h"
#include "eval/output/metrics_table.h"

namespace slammot {

// As metrics.json has it, and back; throws a Json::exception for anything else.
Json json_of(const InForce& in_force);
InForce in_force_of(const Json& json);

// A row per mechanism, a column per run that states any; empty where none does.
std::string in_force_table(const std::vector<NamedMetrics>& results);

// One line about each run in which one option took the effect of another; empty without any. What
// the run itself rules out (known landmarks keep the scale) stands in the table only.
std::string without_effect_lines(const std::vector<NamedMetrics>& results);

}  // namespace slammot
