// slammot report: the page of a study or a comparison again, of stored runs, or of one under a
// slider.
#include <fmt/format.h>

#include <fstream>
#include <memory>

#include "apps/commands.h"
#include "apps/support/command_line.h"
#include "apps/support/judge_options.h"
#include "apps/support/writable.h"
#include "datasets/output/output_folder.h"
#include "eval/compare/report_runs.h"
#include "eval/output/metrics_table.h"
#include "eval/python/report_generator.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

struct ReportArguments {
  JudgeArguments runs;
  std::string output;
  bool timeline = false;
};

// Of bad input the generator has said what is wrong.
int finish(int exit_code, const Path& page) {
  if (exit_code == 0) fmt::print("{}\n", page.string());
  if (exit_code == 1) {
    fmt::print(stderr, "slammot: no report: the generator is missing or failed\n");
  }
  return exit_code;
}

int report_again(const Path& folder) {
  if (std::filesystem::exists(folder / "compare.json")) {
    return finish(make_compare_page(folder), page_of(folder));
  }
  if (std::filesystem::exists(folder / "results.jsonl")) {
    return finish(make_study_page(folder), page_of(folder));
  }
  throw InputError(folder, 0,
                   "holds neither a comparison (compare.json) nor a study (results.jsonl); a run "
                   "is reported with --output DIR, or with --timeline");
}

int report_runs_to(const ReportArguments& arguments) {
  if (arguments.output.empty()) {
    throw std::invalid_argument("report RUN... needs --output DIR for the page");
  }
  const Path output = arguments.output;
  require_output(output, kComparisonOutput, arguments.runs.force);
  require_writable_folder(output);
  const std::vector<JudgedRun> runs = judged(arguments.runs);
  report_runs(runs, output, command_line());
  const int code = make_compare_page(output, true);
  std::vector<NamedMetrics> results;
  for (const JudgedRun& run : runs) {
    results.push_back({run.path.string(), run.estimator, run.stored.landmark, run.metrics});
  }
  fmt::print(stderr, "{}", warning_lines(results));
  return finish(code, page_of(output));
}

int report_timeline(const JudgeArguments& arguments) {
  if (arguments.runs.size() != 1 || arguments.against.size() > 1) {
    throw std::invalid_argument("report --timeline takes one run, and one sequence at most");
  }
  const Path run = arguments.runs.front();
  require_writable_folder(run);
  const Path sequence = arguments.against.empty() ? Path() : Path(arguments.against.front());
  return finish(make_timeline_page(run, sequence), timeline_of(run));
}

int execute(const ReportArguments& arguments) {
  if (arguments.timeline) return report_timeline(arguments.runs);
  const bool again =
      arguments.runs.runs.size() == 1 && arguments.runs.against.empty() && arguments.output.empty();
  return again ? report_again(arguments.runs.runs.front()) : report_runs_to(arguments);
}

}  // namespace

void add_report(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command = app.add_subcommand(
      "report", "report.html: again from a study or a comparison, or of stored runs");
  command
      ->add_option("RUN", arguments->runs.runs,
                   "the folder of a study or comparison; or, with --output, run folders and "
                   "trajectories as `slammot evaluate` takes them")
      ->required();
  add_judge_options(*command, arguments->runs);
  command->add_option("--output", arguments->output, "folder for the page")->type_name("DIR");
  CLI::Option* timeline = command->add_flag(
      "--timeline", arguments->timeline,
      "instead RUN/timeline.html: images, labels, map and NEES of a run under one slider");
  for (const char* other : {"--output", "--error-convention", "--extrinsics", "--time-offset",
                            "--max-difference", "--force-sequence", "--force"}) {
    timeline->excludes(command->get_option(other));  // it would change nothing
  }
  command->callback([arguments, &exit_code] { exit_code = execute(*arguments); });
}

}  // namespace slammot
