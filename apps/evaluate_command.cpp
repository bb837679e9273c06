// slammot evaluate RUN ...: metrics of runs that were made before, here or elsewhere.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "apps/commands.h"
#include "datasets/output/output_files.h"
#include "datasets/text/text_table.h"
#include "eval/output/metrics_json.h"
#include "eval/output/metrics_table.h"
#include "eval/run/evaluate.h"

namespace slammot {
namespace {

struct EvaluateArguments {
  std::vector<std::string> runs;
  std::string against;
  std::string json;
  bool force = false;
};

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

void execute(const EvaluateArguments& arguments) {
  if (!arguments.json.empty()) require_replaceable(arguments.json, arguments.force);
  std::vector<NamedMetrics> results;
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const std::string& folder : arguments.runs) {
    results.push_back(
        evaluate_run(folder, arguments.against.empty()
                                 ? std::nullopt
                                 : std::optional<std::filesystem::path>(arguments.against)));
    json[folder] = metrics_json(results.back().metrics);
  }
  fmt::print("{}", metrics_table(results));
  if (arguments.json.empty()) return;
  write_file(arguments.json, json.dump(1) + '\n');
}

}  // namespace

void add_evaluate(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<EvaluateArguments>();
  CLI::App* command = app.add_subcommand("evaluate", "metrics of stored runs");
  command
      ->add_option("RUN", arguments->runs,
                   "run folders; trajectory.tum is enough, for accuracy only")
      ->required();
  command->add_option("--against", arguments->against, "the sequence with the truth")
      ->type_name("SEQUENCE");
  command->add_option("--json", arguments->json, "write all metrics to this file")
      ->type_name("FILE");
  command->add_flag("--force", arguments->force, "replace an earlier file of `--json`");
  command->callback([arguments, &exit_code] {
    execute(*arguments);
    exit_code = 0;
  });
}

}  // namespace slammot
