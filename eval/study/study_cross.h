// The cells of a study: each scenario with each combination of the swept values, by each estimator.
#pragma once

#include <nlohmann/json.hpp>

#include "eval/study/study.h"

namespace slammot {

using Settings = std::vector<std::pair<std::string, std::string>>;

struct NamedSettings {
  std::string label;
  int line = 0;      // in the study's file
  std::string name;  // of the scenario or the estimator; folder of a recorded sequence
  bool recorded = false;
  Settings settings;
};

// `scenario.KEY` is a parameter of the scenario, any other key one of the configuration.
struct SweptKey {
  std::string key;
  std::vector<std::string> values;
};

bool is_of_scenario(std::string_view key);

// How the lines of a study's text begin that `slammot study --set` adds.
inline constexpr std::string_view kSetLine = "# --set ";

// What these lines set. Throws std::invalid_argument for what is no key or no value.
Settings settings_in(std::string_view text);

// Throws std::invalid_argument for a key that the sweep or an estimator sets itself, for which it
// would be without effect.
void require_free(const Settings& set, const std::vector<NamedSettings>& estimators,
                  const std::vector<SweptKey>& sweep);

// Every key with its value, as the cell's estimator adjusts them.
nlohmann::ordered_json configuration_json(const StudyCell& cell);

// In this order, estimators fastest; `all` is set for every one. Throws std::invalid_argument for
// more than 100,000 combinations, and for an unknown estimator or key or a bad value.
std::vector<StudyCell> cross(const std::vector<NamedSettings>& scenarios,
                             const std::vector<SweptKey>& sweep,
                             const std::vector<NamedSettings>& estimators, const Settings& all);

}  // namespace slammot
