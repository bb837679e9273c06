// slammot report DIR: figures, tables and report.html again, from a study or a comparison.
#include <fmt/format.h>

#include <fstream>
#include <memory>

#include "apps/commands.h"
#include "eval/report/report_generator.h"
#include "eval/study/study_summary.h"

namespace slammot {
namespace {

int execute(const std::filesystem::path& folder) {
  std::optional<std::filesystem::path> report;
  if (std::filesystem::exists(folder / "compare.json")) {
    report = write_compare_report(folder);
  } else if (std::filesystem::exists(folder / "results.jsonl")) {
    report = write_study_report(folder);
  } else {
    throw InputError(folder, 0,
                     "holds neither a comparison (compare.json) nor a study (results.jsonl)");
  }
  if (!report) {
    fmt::print(stderr, "slammot: no report: the generator is missing or failed\n");
    return 1;
  }
  fmt::print("{}\n", report->string());
  return 0;
}

}  // namespace

void add_report(CLI::App& app, int& exit_code) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("report", "report.html and figures from a study or a comparison");
  command->add_option("DIR", *folder, "its output folder")->required();
  command->callback([folder, &exit_code] { exit_code = execute(*folder); });
}

}  // namespace slammot
