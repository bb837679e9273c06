// Presets: a name for many settings. A key that is given by itself overrides its preset, whichever
// of the two was given first.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "eval/configuration/configuration.h"

namespace slammot {

std::vector<std::string> preset_names();

// Its settings, where they are not the defaults; throws std::invalid_argument naming the known
// presets.
std::vector<Assignment> preset_settings(const std::string& preset);

// The settings of `preset` for all keys that were not given (Configuration::given).
void take_preset(Configuration& configuration, const std::string& preset);

// What the thesis does not state and a run with its preset needs all the same: keys of a resolved
// configuration, each with "VALUE, WHY". Empty with another preset.
std::vector<std::pair<std::string, std::string>> left_open_by_the_thesis(
    const Configuration& resolved);

}  // namespace slammot
