#include "apps/support/configuration_options.h"

#include <fmt/format.h>

namespace slammot {
namespace {

std::string keys_help() {
  std::string text = "Configuration keys (default), for --set and --config:\n";
  const Configuration defaults;
  for (const ConfigurationKey& key : configuration_keys()) {
    text += fmt::format("  {:<30} {} ({})\n", key.name, key.help, key.get(defaults));
  }
  return text + "  `sequence` is what the sequence states, or the model's default.";
}

}  // namespace

void add_configuration_options(CLI::App& command, ConfigurationOptions& options) {
  command.add_option("--config", options.file, "YAML file of configuration keys, or a run.yaml")
      ->type_name("FILE");
  command.add_option("--set", options.settings, "one configuration key; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command.footer(keys_help);
}

Configuration configuration_from(const ConfigurationOptions& options,
                                 std::vector<Assignment>* set) {
  Configuration configuration;
  std::vector<Assignment> assigned;
  if (!options.file.empty()) assigned = load_configuration(configuration, options.file);
  for (const std::string& text : options.settings) {
    assigned.push_back(parse_assignment(text));
    assign(configuration, assigned.back());
  }
  if (set != nullptr) *set = assigned;
  return configuration;
}

}  // namespace slammot
