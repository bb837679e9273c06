// The cells of a study: each scenario with each combination of the swept values, by each estimator.
#pragma once

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

// In this order, estimators fastest; `all` is set for every one. Throws std::invalid_argument for
// more than 100,000 combinations, and for an unknown estimator or key or a bad value.
std::vector<StudyCell> cross(const std::vector<NamedSettings>& scenarios,
                             const std::vector<SweptKey>& sweep,
                             const std::vector<NamedSettings>& estimators, const Settings& all);

}  // namespace slammot
