// slammot compare [SEQUENCE]: estimators side by side, a table and a report. The main job.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "apps/commands.h"
#include "apps/pictures/draw_run.h"
#include "apps/support/command_line.h"
#include "apps/support/configuration_options.h"
#include "apps/support/progress.h"
#include "apps/support/sequence_source.h"
#include "apps/support/usage.h"
#include "apps/support/writable.h"
#include "datasets/native/native_writer.h"
#include "datasets/output/file_lock.h"
#include "datasets/output/output_files.h"
#include "datasets/output/output_folder.h"
#include "datasets/readers/reader.h"
#include "datasets/text/text_table.h"
#include "eval/compare/compare.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/output/in_force.h"
#include "eval/output/metrics_table.h"
#include "eval/python/report_generator.h"
#include "frontend/odometry/rotation_check.h"

namespace slammot {
namespace {

constexpr char kSequence[] = "sequence";
constexpr char kPictures[] = "pictures";

struct CompareArguments {
  std::string sequence;
  std::string output;
  std::vector<std::string> estimators = {"ekf", "window"};
  std::vector<std::string> landmarks;
  ScenarioOptions scenario;
  ConfigurationOptions configuration;
  bool pictures = false;
  bool force = false;
  bool verbose = false;
};

std::filesystem::path output_folder(const CompareArguments& arguments) {
  if (!arguments.output.empty()) return arguments.output;
  const std::filesystem::path sequence =
      std::filesystem::path(arguments.sequence).lexically_normal();
  const auto name =
      sequence.has_filename() ? sequence.filename() : sequence.parent_path().filename();
  return std::filesystem::path("slammot-out") /
         ("compare-" + (arguments.sequence.empty() ? arguments.scenario.scenario : name.string()));
}

// A landmark model that was set in the configuration, or by a preset, is the only one compared.
std::vector<std::string> landmarks_compared(const CompareArguments& arguments,
                                            const std::vector<Assignment>& set,
                                            const Configuration& configuration) {
  const bool is_set = std::ranges::any_of(set, [](const auto& a) { return a.key == "landmark"; });
  if (is_set) return {configuration.model.landmark};
  if (!arguments.landmarks.empty()) return arguments.landmarks;
  if (configuration.model.landmark != ModelOptions{}.landmark)
    return {configuration.model.landmark};
  return {"dynamic_inverse_depth", "scaled_velocity"};
}

Sequence obtain(const CompareArguments& arguments, const std::filesystem::path& output) {
  if (!arguments.sequence.empty()) return read_sequence(arguments.sequence);
  fmt::print("simulating scenario {}, seed {}\n", arguments.scenario.scenario,
             arguments.scenario.seed);
  return simulate_to(arguments.scenario, output / kSequence);
}

// The report takes them from each run's folder.
void draw_all(const std::vector<NamedMetrics>& results, const Sequence& sequence,
              const std::filesystem::path& output, Progress& progress) {
  for (const NamedMetrics& result : results) {
    const auto run = output / result.label;
    draw_run(run, sequence, run / kPictures, [&](int done, int total) {
      progress.show("pictures of " + result.label, done, total);
    });
  }
}

void say_what_is_wrong(const std::vector<NamedMetrics>& results) {
  fmt::print(stderr, "{}", warning_lines(results));
  for (const NamedMetrics& result : results) {
    const auto& diverged = result.metrics.diverged;
    if (!diverged) continue;
    fmt::print(stderr, "slammot: {} diverged at frame {}: {}\n", result.label, diverged->frame,
               diverged->reason);
  }
}

// Everything that will be written into, before anything is. What a comparison that ended before its
// first run leaves is replaced, and any other with --force. No other process may write there while
// the lock lives, which is taken before the folder is looked at, but never put beside foreign
// files.
std::unique_ptr<FileLock> claim(const CompareArguments& arguments,
                                const std::filesystem::path& output,
                                const std::vector<ComparedRun>& runs) {
  const std::filesystem::path& input = arguments.sequence;
  require_output(output, kComparisonOutput, true, input);
  require_writable_folder(output);
  std::filesystem::create_directories(output);
  auto lock = std::make_unique<FileLock>(output / kLockFile);
  const bool replace = arguments.force || arguments.output.empty();
  const auto mark = output / kComparisonOutput.mark;
  const std::string begun = std::string(kComparisonOutput.begins) + ",\n \"runs\": []\n}\n";
  const bool unfinished = std::filesystem::exists(mark) && read_text_file(mark) == begun;
  require_output(output, kComparisonOutput, replace || unfinished, input);
  if (input.empty()) {
    require_output(output / kSequence, kSequenceOutput, replace || unfinished);
    require_own_files(output / kSequence);
  }
  for (const ComparedRun& run : runs) {
    require_output(output / run.label, kRunOutput, replace, input);
    if (!arguments.pictures) continue;
    require_output(output / run.label / kPictures, kPicturesOutput, replace, input);
  }
  if (!std::filesystem::exists(mark)) write_file(mark, begun);
  return lock;
}

int finish(const std::vector<NamedMetrics>& results, const std::filesystem::path& output,
           bool verbose) {
  fmt::print("\n{}\n", metrics_table(results));
  if (verbose) fmt::print("{}\n", in_force_table(results));
  std::fflush(stdout);
  fmt::print(stderr, "{}", without_effect_lines(results));
  say_what_is_wrong(results);
  const bool diverged = std::any_of(results.begin(), results.end(),
                                    [](const auto& r) { return r.metrics.diverged.has_value(); });
  if (make_compare_page(output) != 0) {
    fmt::print(stderr, "slammot: no report; the runs are in {}\n", output.string());
    return 1;
  }
  fmt::print("{}\n", page_of(output).string());
  return diverged ? 1 : 0;
}

int execute(CompareArguments arguments) {
  for (const std::string& name : arguments.estimators) {
    find_estimator(with_settings(name).estimator);
  }
  std::vector<Assignment> set;
  const Configuration configuration = configuration_from(arguments.configuration, &set);
  const auto landmarks = landmarks_compared(arguments, set, configuration);
  if (arguments.scenario.scenario.empty()) arguments.scenario.scenario = "circle";
  const std::filesystem::path output = output_folder(arguments);
  const auto runs = crossed(arguments.estimators, landmarks);
  const auto lock = claim(arguments, output, runs);
  const Sequence sequence = selected(obtain(arguments, output), configuration.frames);
  if (arguments.pictures && sequence.images.empty()) {
    throw InputError(sequence.folder, 0, "--pictures: frames.csv names no images");
  }
  fmt::print("{}: {} frames, {} estimators x {} landmark models\n", sequence.name,
             sequence.frames.size(), arguments.estimators.size(), landmarks.size());
  Progress progress;
  CompareOptions options;
  options.output = output;
  options.command = command_line();
  options.landmarks_every_frame = arguments.pictures;
  options.check_rotation = check_rotation;
  if (arguments.sequence.empty()) options.seed = arguments.scenario.seed;
  options.progress = [&](const std::string& label, std::size_t run, int done, int total) {
    progress.show(fmt::format("{} (run {} of {})", label, run + 1, runs.size()), done, total);
  };
  const auto results = compare(sequence, configuration, runs, options);
  if (arguments.pictures) draw_all(results, sequence, output, progress);
  progress.clear();
  return finish(results, output, arguments.verbose);
}

}  // namespace

void add_compare(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command = app.add_subcommand(
      "compare", "estimators side by side on one sequence: a table and report.html");
  auto* sequence = command->add_option("SEQUENCE", arguments->sequence,
                                       "folder with the sequence; without it one is simulated");
  command->add_option("--output", arguments->output, "folder for the runs and the report")
      ->type_name("DIR");
  command
      ->add_option("--estimator", arguments->estimators,
                   "or python:FILE.py:Class; may be repeated, with settings of its own too")
      ->type_name("NAME[:KEY=VALUE,..]")
      ->allow_extra_args(false)
      ->capture_default_str();
  command
      ->add_option("--landmark", arguments->landmarks,
                   "landmark model; may be repeated (dynamic_inverse_depth and scaled_velocity)")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command->add_option("--scenario", arguments->scenario.scenario, "simulate this one (circle)")
      ->type_name("NAME")
      ->excludes(sequence);
  command->add_option("--seed", arguments->scenario.seed, "of the simulation")
      ->excludes(sequence)
      ->check(whole_number_from(0))
      ->capture_default_str();
  command->add_option("--scenario-set", arguments->scenario.settings, "a parameter of the scenario")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false)
      ->excludes(sequence);
  command->add_flag("--pictures", arguments->pictures,
                    "of every frame, as PNG and as a film, and in the report; wants images");
  command->add_flag("--force", arguments->force, kForceHelp);
  command->add_flag("--verbose", arguments->verbose, kVerboseHelp);
  add_configuration_options(*command, arguments->configuration);
  command->callback([arguments, &exit_code] { exit_code = execute(*arguments); });
}

}  // namespace slammot
