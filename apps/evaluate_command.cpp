// slammot evaluate RUN ...: metrics of runs that were made before, here or elsewhere.
#include <fmt/format.h>

#include <fstream>
#include <memory>

#include "apps/commands.h"
#include "apps/support/judge_options.h"
#include "eval/output/metrics_json.h"
#include "eval/output/metrics_table.h"

namespace slammot {
namespace {

void execute(const JudgeArguments& arguments, const std::string& json_file) {
  std::vector<NamedMetrics> results;
  Json json = Json::object();
  for (const JudgedRun& run : judged(arguments)) {
    results.push_back({run_name(run.path), run.estimator, run.stored.landmark, run.metrics});
    json[run.path.string()] = metrics_json(run.metrics);
  }
  fmt::print("{}", metrics_table(results));
  if (json_file.empty()) return;
  std::ofstream out(json_file);
  out.exceptions(std::ios::badbit | std::ios::failbit);
  out << json.dump(1) << '\n';
}

}  // namespace

void add_evaluate(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<JudgeArguments>();
  auto json = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("evaluate", "metrics of stored runs");
  command
      ->add_option("RUN", arguments->runs,
                   "run folders, of which trajectory.tum is enough for accuracy, or trajectories "
                   "as TUM, KITTI, EuRoC or ov_eval files")
      ->required();
  add_judge_options(*command, *arguments);
  command->add_option("--json", *json, "write all metrics to this file")->type_name("FILE");
  command->callback([arguments, json, &exit_code] {
    execute(*arguments, *json);
    exit_code = 0;
  });
}

}  // namespace slammot
