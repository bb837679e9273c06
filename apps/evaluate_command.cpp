// slammot evaluate RUN ...: metrics of runs that were made before, here or elsewhere.
#include <fmt/format.h>

#include <fstream>
#include <memory>

#include "apps/commands.h"
#include "apps/support/writable.h"
#include "eval/output/metrics_json.h"
#include "eval/output/metrics_table.h"
#include "eval/run/evaluate.h"

namespace slammot {
namespace {

struct EvaluateArguments {
  std::vector<std::string> runs;
  std::string against;
  std::string json;
};

void execute(const EvaluateArguments& arguments) {
  if (!arguments.json.empty()) require_writable_file(arguments.json);
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
  std::ofstream out(arguments.json);
  out.exceptions(std::ios::badbit | std::ios::failbit);
  out << json.dump(1) << '\n';
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
  command->callback([arguments, &exit_code] {
    execute(*arguments);
    exit_code = 0;
  });
}

}  // namespace slammot
