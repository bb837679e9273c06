// slammot run SEQUENCE --estimator NAME: one estimator, one run folder.
#include <fmt/format.h>

#include <memory>

#include "apps/commands.h"
#include "apps/support/command_line.h"
#include "apps/support/configuration_options.h"
#include "apps/support/progress.h"
#include "apps/support/sequence_source.h"
#include "apps/support/writable.h"
#include "datasets/output/output_folder.h"
#include "datasets/readers/reader.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/output/in_force.h"
#include "eval/output/metrics_table.h"
#include "eval/output/run_writer.h"
#include "eval/run/evaluate.h"
#include "eval/run/run.h"
#include "frontend/odometry/rotation_check.h"

namespace slammot {
namespace {

struct RunArguments {
  std::string sequence;
  std::string estimator;
  std::string output;
  std::string landmarks = "final";
  bool force = false;
  bool verbose = false;
  ConfigurationOptions configuration;
};

// What a run says of itself after its table; the exit code.
int tell(const RunResult& run, const RunMetrics& metrics, const std::string& estimator,
         bool exact_truth) {
  for (const RunWarning& w : run.warnings) {
    fmt::print(stderr, "slammot: warning: {}{}\n", estimator, told(w));
  }
  if (metrics.failed) {
    fmt::print(stderr, "slammot: failed at frame {}: the error exceeds {}\n", *metrics.failed,
               failure_bound(!exact_truth));
  }
  if (!run.diverged) return 0;
  fmt::print(stderr, "slammot: diverged at frame {}: {}\n", run.diverged->frame,
             run.diverged->reason);
  return 1;
}

int execute(const RunArguments& arguments) {
  const EstimatorRow& row = find_estimator(arguments.estimator);  // before anything slow
  const Configuration configuration = configuration_from(arguments.configuration);
  const Sequence sequence = selected(read_sequence(arguments.sequence), configuration.frames);
  const std::string output =
      arguments.output.empty()
          ? fmt::format("slammot-out/run-{}-{}", sequence.name, estimator_label(row.name))
          : arguments.output;
  require_output(output, kRunOutput, arguments.force || arguments.output.empty(), sequence.folder);
  require_writable_folder(output);
  if (const auto warning = warning_about(sequence, configuration, arguments.estimator)) {
    fmt::print(stderr, "slammot: warning: {}\n", *warning);
  }
  Progress progress;
  DriveOptions options;
  options.landmarks_every_frame = options.predictions = arguments.landmarks == "every-frame";
  options.check_rotation = check_rotation;
  options.progress = [&](int done, int total) { progress.show(arguments.estimator, done, total); };
  const auto [effective, from_sequence, run, metrics] =
      run_and_evaluate(sequence, configuration, arguments.estimator, options);
  progress.clear();
  write_run(output,
            {command_line(), arguments.estimator, sequence.folder, sequence.name, sequence.sha256,
             std::nullopt, effective, from_sequence},
            run, metrics);
  const std::string landmark = row.has_models ? effective.model.landmark : "-";
  const std::vector<NamedMetrics> named = {
      {run_name(output), estimator_label(row.name), landmark, metrics}};
  fmt::print("{}{}{}\n", metrics_table(named), arguments.verbose ? in_force_table(named) : "",
             output);
  fmt::print(stderr, "{}", without_effect_lines(named));
  return tell(run, metrics, arguments.estimator, sequence.exact_truth);
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "run one estimator on a sequence");
  command->add_option("SEQUENCE", arguments->sequence, "folder with the sequence")->required();
  command
      ->add_option("--estimator", arguments->estimator,
                   "see `slammot list estimators`; or python:FILE.py:Class")
      ->type_name("NAME")
      ->required();
  command->add_option("--output", arguments->output, "folder for the run")->type_name("DIR");
  command
      ->add_option("--landmarks", arguments->landmarks,
                   "rows of landmarks.csv: the final state "
                   "of each, or all of every frame, and predictions.csv")
      ->check(CLI::IsMember({"final", "every-frame"}));
  command->add_flag("--force", arguments->force, kForceHelp);
  command->add_flag("--verbose", arguments->verbose, kVerboseHelp);
  add_configuration_options(*command, arguments->configuration);
  command->callback([arguments, &exit_code] { exit_code = execute(*arguments); });
}

}  // namespace slammot
