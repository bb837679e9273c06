// slammot evaluate RUN ...: metrics of runs that were made before, here or elsewhere.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "apps/commands.h"
#include "apps/support/judge_options.h"
#include "apps/support/writable.h"
#include "datasets/output/output_files.h"
#include "datasets/text/text_table.h"
#include "eval/output/metrics_json.h"
#include "eval/output/metrics_table.h"

namespace slammot {
namespace {

// A file of this program's own making: metrics under the names of runs.
bool is_evaluation(const std::filesystem::path& file) {
  const auto json = nlohmann::json::parse(read_text_file(file), nullptr, false);
  return json.is_object() && !json.empty() &&
         std::all_of(json.begin(), json.end(),
                     [](const auto& run) { return run.is_object() && run.contains("filtered"); });
}

void require_replaceable(const std::filesystem::path& file, bool force) {
  if (!std::filesystem::exists(file) || std::filesystem::is_character_file(file) ||
      std::filesystem::is_fifo(file)) {
    return;
  }
  if (!force)
    throw std::invalid_argument(file.string() + ": is there already: --force replaces it");
  if (!is_evaluation(file)) {
    throw std::invalid_argument(file.string() +
                                ": was not written by `evaluate`: it is not replaced");
  }
}

void execute(const JudgeArguments& arguments, const std::string& json_file) {
  if (!json_file.empty()) {
    require_replaceable(json_file, arguments.force);
    require_writable_file(json_file);
  }
  std::vector<NamedMetrics> results;
  Json json = Json::object();
  for (const JudgedRun& run : judged(arguments)) {
    results.push_back(
        {run_name(run.path), run.estimator, run.stored.landmark, run.metrics, run.sequence->name});
    json[run.path.string()] = metrics_json(run.metrics);
  }
  fmt::print("{}", metrics_table(results));
  std::fflush(stdout);
  fmt::print(stderr, "{}", warning_lines(results));
  if (json_file.empty()) return;
  write_file(json_file, json.dump(1) + '\n');
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
