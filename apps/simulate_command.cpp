// slammot simulate SCENARIO: a simulated sequence as a folder.
#include <fmt/format.h>

#include <memory>

#include "slammot/apps/commands.h"
#include "slammot/apps/sequence_source.h"
#include "slammot/datasets/scenario.h"

namespace slammot {
namespace {

struct SimulateArguments {
  ScenarioOptions scenario;
  std::string output;
};

std::string parameters_help() {
  std::string text = "Parameters of the scenarios (default), for --set:\n";
  for (const ScenarioRow& row : scenario_table()) {
    text += fmt::format("{}: {}\n", row.name, row.description);
    for (const ScenarioParameter& parameter : row.parameters()) {
      text += fmt::format("  {:<28} {} ({})\n", parameter.name, parameter.help, parameter.value);
    }
  }
  return text;
}

void execute(const SimulateArguments& arguments) {
  const Sequence sequence = simulate_to(arguments.scenario, arguments.output);
  fmt::print("{}: {} frames, {} landmarks, seed {}\n{}\n", sequence.name, sequence.frames.size(),
             sequence.landmarks.size(), arguments.scenario.seed, arguments.output);
}

}  // namespace

void add_simulate(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand("simulate", "write a simulated sequence");
  command->add_option("SCENARIO", arguments->scenario.scenario, "see `slammot list scenarios`")
      ->required();
  command->add_option("--seed", arguments->scenario.seed)->capture_default_str();
  command->add_option("--set", arguments->scenario.settings, "one parameter; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command->add_option("--output", arguments->output, "folder to write")
      ->type_name("SEQUENCE")
      ->required();
  command->footer(parameters_help);
  command->callback([arguments, &exit_code] {
    execute(*arguments);
    exit_code = 0;
  });
}

}  // namespace slammot
