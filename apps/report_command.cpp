// slammot report: the page of a study or a comparison again, or of stored runs.
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
#include "eval/report/report_generator.h"
#include "eval/study/summary/study_summary.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

struct ReportArguments {
  JudgeArguments runs;
  std::string output;
};

// Of bad input the generator has said what is wrong.
int finish(int exit_code, const Path& folder) {
  if (exit_code == 0) fmt::print("{}\n", (folder / "report.html").string());
  if (exit_code == 1) {
    fmt::print(stderr, "slammot: no report: the generator is missing or failed\n");
  }
  return exit_code;
}

int report_again(const Path& folder) {
  if (std::filesystem::exists(folder / "compare.json")) {
    return finish(make_compare_page(folder), folder);
  }
  if (std::filesystem::exists(folder / "results.jsonl")) {
    return finish(make_study_page(folder), folder);
  }
  throw InputError(folder, 0,
                   "holds neither a comparison (compare.json) nor a study (results.jsonl); a run "
                   "is reported with --output DIR");
}

std::string with_interval(const Json& estimate, int decimals) {
  if (!estimate.is_object()) return "-";
  const auto part = [&](const char* key) { return estimate.at(key).get<double>(); };
  std::string value = fmt::format("{:.{}f}", part("value"), decimals);
  if (std::isnan(part("lower"))) return value;
  return fmt::format("{} [{:.{}f}, {:.{}f}]", value, part("lower"), decimals, part("upper"),
                     decimals);
}

Json value_of(const Json& estimator, const std::string& key) {
  const Json& values = estimator.at("values");
  return values.contains(key) ? values.at(key) : Json();
}

Json anees_of(const Json& estimator, const std::string& part) {
  const Json& anees = estimator.at("anees");
  if (!anees.contains(part)) return {};
  Json estimate = anees.at(part);
  estimate["value"] = estimate.at("mean");
  return estimate;
}

std::string inside_of(const Json& estimator) {
  const Json pose = anees_of(estimator, "pose");
  if (!pose.is_object() || pose.at("infinite") != 0) return "-";
  return fmt::format("{:.0f}%", 100.0 * pose.at("inside").get<double>());
}

std::string coverage_of(const Json& estimator) {
  const Json coverage = value_of(estimator, "coverage");
  return coverage.is_object() ? fmt::format("{:.1f}%", 100.0 * coverage.at("value").get<double>())
                              : "-";
}

// A row for each estimator, its runs put together.
std::string pooled_table(const Json& estimators) {
  std::vector<TextRow> rows = {{"estimator", "runs", "coverage", "failed", "diverged", "warned",
                                "position RMSE m", "ATE Sim(3) m", "ANEES pose (6)",
                                "ANEES position (3)", "frames inside"}};
  for (const Json& e : estimators) {
    rows.push_back({e.at("name").get<std::string>(), e.at("runs").dump(), coverage_of(e),
                    e.at("failed").dump(), e.at("diverged").dump(), e.at("warned").dump(),
                    with_interval(value_of(e, kPositionRmse), 4),
                    with_interval(value_of(e, kAteSim3), 4), with_interval(anees_of(e, "pose"), 3),
                    with_interval(anees_of(e, "position"), 3), inside_of(e)});
  }
  return aligned(rows, 1) +
         "Errors: root mean square over the runs that did not diverge. In brackets: 95% bootstrap "
         "interval over runs.\nFrames inside: those whose NEES, averaged over the runs, lies in "
         "the 95% interval of a consistent estimator.\n";
}

int report_runs_to(const ReportArguments& arguments) {
  if (arguments.output.empty()) {
    throw std::invalid_argument("report RUN... needs --output DIR for the page");
  }
  const Path output = arguments.output;
  require_output(output, kComparisonOutput, arguments.runs.force);
  require_writable_folder(output);
  const std::vector<JudgedRun> runs = judged(arguments.runs);
  const Json estimators = report_runs(runs, output, command_line());
  fmt::print("{}", pooled_table(estimators));
  std::fflush(stdout);
  std::vector<NamedMetrics> results;
  for (const JudgedRun& run : runs) {
    results.push_back({run.path.string(), run.estimator, run.stored.landmark, run.metrics});
  }
  fmt::print(stderr, "{}", warning_lines(results));
  return finish(make_compare_page(output), output);
}

int execute(const ReportArguments& arguments) {
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
  command->callback([arguments, &exit_code] { exit_code = execute(*arguments); });
}

}  // namespace slammot
