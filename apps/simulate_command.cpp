// slammot simulate SCENARIO: a simulated sequence as a folder.
#include <fmt/format.h>

#include <memory>

#include "apps/commands.h"
#include "apps/support/sequence_source.h"
#include "apps/support/usage.h"
#include "apps/support/writable.h"
#include "datasets/native/native_writer.h"
#include "datasets/output/output_folder.h"
#include "datasets/simulation/parameters/parameters.h"
#include "datasets/simulation/scenario.h"
#include "frontend/rendering/render.h"

namespace slammot {
namespace {

struct SimulateArguments {
  ScenarioOptions scenario;
  std::string output;
  bool render = false;
  bool force = false;
};

std::string scenario_help(std::string_view name, std::string_view description,
                          const std::vector<ScenarioParameter>& parameters) {
  std::string text = fmt::format("{}: {}\n", name, description);
  for (const ScenarioParameter& parameter : parameters) {
    text += fmt::format("  {:<28} {} ({})\n", parameter.name, parameter.help, parameter.value);
  }
  return text;
}

std::string parameters_help() {
  std::string text = "Parameters of the scenarios (default), for --set:\n";
  for (const ScenarioRow& row : scenario_table()) {
    text += scenario_help(row.name, row.description, row.parameters());
  }
  return text;
}

// Of the scenes with surfaces.
RoomOptions rendered_options(const std::string& scenario) {
  const RoomOptions room, basement = basement_options();
  if (scenario.empty() || scenario == name_of(room.scene)) return room;
  if (scenario == name_of(basement.scene)) return basement;
  throw std::invalid_argument(
      fmt::format("scenario '{}' has points, no surfaces: only '{}' and '{}' can be rendered",
                  scenario, name_of(room.scene), name_of(basement.scene)));
}

// Images only; `slammot track` makes the measurements and their truth.
void render_images(const SimulateArguments& arguments) {
  const RoomOptions options = rendered_options(arguments.scenario.scenario);
  const Sequence sequence = write_room(options, overrides_of(arguments.scenario),
                                       arguments.scenario.seed, arguments.output);
  const std::size_t images = sequence.frames.size() * (1 + sequence.other_images.size());
  fmt::print("{}: {} images, seed {}\n{}\n", sequence.name, images, arguments.scenario.seed,
             arguments.output);
}

void execute(const SimulateArguments& arguments) {
  require_output(arguments.output, kSequenceOutput, arguments.force);
  require_own_files(arguments.output);
  if (arguments.render) require_own_room(arguments.output);
  require_writable_folder(arguments.output);
  if (arguments.render) return render_images(arguments);
  if (arguments.scenario.scenario.empty()) throw std::invalid_argument("which SCENARIO?");
  const Sequence sequence = simulate_to(arguments.scenario, arguments.output);
  fmt::print("{}: {} frames, {} landmarks, seed {}\n{}\n", sequence.name, sequence.frames.size(),
             sequence.landmarks.size(), arguments.scenario.seed, arguments.output);
}

}  // namespace

void add_simulate(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand("simulate", "write a simulated sequence");
  command->add_option("SCENARIO", arguments->scenario.scenario, "see `slammot list scenarios`");
  command->add_flag("--render", arguments->render,
                    "images of a textured room, for `slammot track`");
  command->add_option("--seed", arguments->scenario.seed, "of all noise")
      ->check(whole_number_from(0))
      ->capture_default_str();
  command->add_option("--set", arguments->scenario.settings, "one parameter; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command->add_option("--output", arguments->output, "folder to write")
      ->type_name("SEQUENCE")
      ->required();
  command->add_flag("--force", arguments->force, kForceHelp);
  command->footer(parameters_help);
  command->callback([arguments, &exit_code] {
    execute(*arguments);
    exit_code = 0;
  });
}

}  // namespace slammot
