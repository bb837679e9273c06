// `--config` and `--set`, the same for every command that runs estimators.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "eval/configuration/configuration.h"

namespace slammot {

struct ConfigurationOptions {
  std::string file;
  std::vector<std::string> settings;
};

// The help of the command then lists all keys with their defaults.
void add_configuration_options(CLI::App& command, ConfigurationOptions& options);

// The file first, then the settings. `set` receives what was assigned.
Configuration configuration_from(const ConfigurationOptions& options,
                                 std::vector<Assignment>* set = nullptr);

}  // namespace slammot
