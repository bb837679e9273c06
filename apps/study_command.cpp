// slammot study STUDY.yaml: scenarios x estimators x swept values x seeds, in parallel.
#include <fmt/format.h>

#include <memory>
#include <thread>

#include "apps/commands.h"
#include "apps/support/progress.h"
#include "apps/support/usage.h"
#include "apps/support/writable.h"
#include "datasets/output/output_files.h"
#include "datasets/text/number.h"
#include "eval/report/report_generator.h"
#include "eval/study/study_driver.h"
#include "eval/study/study_view.h"
#include "eval/study/summary/study_summary.h"
#include "eval/study/table/runs_table.h"
#include "frontend/odometry/rotation_check.h"

namespace slammot {
namespace {

struct StudyArguments {
  std::string study;
  std::string output;
  std::string shard;
  std::vector<std::string> merge;
  bool merge_only = false;
  bool resume = false;
  bool force = false;
  int runs = 0;
  int jobs = 0;
};

Shard parse_shard(const std::string& text) {
  if (text.empty()) return {};
  const auto [first, second] = cut_at('/', text);
  const auto index = parse_number<int>(first), count = parse_number<int>(second);
  if (!index || !count || *index < 1 || *index > *count) {
    throw std::invalid_argument("--shard must be I/N with 1 <= I <= N, not '" + text + "'");
  }
  return {*index, *count};
}

int finish(const Study& study, const std::filesystem::path& output,
           const std::vector<std::filesystem::path>& folders, int jobs, bool mix) {
  merge_runs(study, folders, output, mix);
  write_runs_table(study, output);
  write_file(output / "summary.json",
             summarise_study(study, output, provenance(jobs)).dump(1) + '\n');
  write_file(output / "view.json", study_view(study).dump() + '\n');
  if (make_study_page(output) != 0) {
    fmt::print(stderr, "slammot: no report; the results are in {}\n", output.string());
    return 1;
  }
  fmt::print("{}\n", page_of(output).string());
  return 0;
}

// A recording to which no noise is added is one run, whatever the number of runs.
std::string runs_text(const Study& study) {
  std::size_t single = 0;
  for (std::size_t i = 0; i < study.cells.size(); ++i) {
    if (study.runs_of(i) < study.runs) ++single;
  }
  if (single == study.cells.size()) return "one run of each (recordings without added noise)";
  return fmt::format("{} runs of each{}", study.runs,
                     single == 0 ? "" : ", one of a recording without added noise");
}

int execute(const StudyArguments& arguments) {
  const Shard shard = parse_shard(arguments.shard);
  Study study = read_study(arguments.study);
  if (arguments.runs > 0) study.runs = arguments.runs;
  const std::filesystem::path output =
      arguments.output.empty() ? std::filesystem::path("slammot-out") / ("study-" + study.name)
                               : std::filesystem::path(arguments.output);
  require_writable_folder(output);
  if (arguments.merge_only) {
    claim_folder(study, output, shard, true);
    std::vector<std::filesystem::path> folders(arguments.merge.begin(), arguments.merge.end());
    if (folders.empty()) folders.push_back(output);
    return finish(study, output, folders, 0, arguments.force);
  }
  // Twice the same command is once: what stands in the study's own folder is gone on with.
  const bool resume = arguments.resume || arguments.output.empty();
  claim_folder(study, output, shard, resume);
  StudyOptions options;
  options.output = output;
  options.shard = shard;
  options.mix = arguments.force;
  options.check_rotation = check_rotation;
  options.jobs =
      arguments.jobs > 0 ? arguments.jobs : static_cast<int>(std::thread::hardware_concurrency());
  Progress progress("run", "runs");
  options.progress = [&](const StudyProgress& p) {
    const std::string frames =
        p.frames > 0 ? fmt::format(", frame {} of {}", p.frames_done, p.frames) : "";
    progress.show(study.name, p.runs_done + p.parts_done, p.runs, frames);
  };
  fmt::print("{}: {} scenarios and swept values x estimators, {}, {} at a time\n", study.name,
             study.cells.size(), runs_text(study), options.jobs);
  std::fflush(stdout);
  const int ran = run_study(study, options);
  progress.clear();
  fmt::print("{} runs done{}\n", ran, resume ? ", the others were there" : "");
  if (shard.count == 1) return finish(study, output, {output}, options.jobs, arguments.force);
  fmt::print(
      "shard {} of {} is in {}; when all are there: slammot study {} --merge --output {}; or, of a "
      "folder each: --merge DIR1 DIR2 ... --output DIR\n",
      shard.index, shard.count, output.string(), arguments.study, output.string());
  return 0;
}

}  // namespace

void add_study(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<StudyArguments>();
  CLI::App* command = app.add_subcommand(
      "study", "many runs: scenarios x estimators x swept values x seeds, from a YAML file");
  command->add_option("STUDY", arguments->study, "see docs/formats.md and eval/studies/")
      ->required();
  command->add_option("--output", arguments->output, "folder for runs and report")
      ->type_name("DIR");
  command->add_option("--runs", arguments->runs, "seeds of each cell, instead of the file's number")
      ->check(whole_number_from(1));
  command->add_option("--jobs", arguments->jobs, "runs at a time; all cores without it")
      ->check(whole_number_from(1));
  auto* shard =
      command->add_option("--shard", arguments->shard, "only every N-th run, from the I-th")
          ->type_name("I/N");
  command->add_flag("--resume", arguments->resume,
                    "go on with what the folder holds; without --output always");
  command->add_flag("--force", arguments->force,
                    "take runs that another build of the program made, or that were made of a "
                    "recording that has changed, and mix them");
  auto* merge =
      command
          ->add_option(
              "--merge", arguments->merge,
              "run only what the report shows; put together the shards in these folders (in the "
              "output folder, if none is named)")
          ->type_name("DIR")
          ->expected(0, -1)
          ->excludes(shard);
  command->callback([arguments, merge, &exit_code] {
    arguments->merge_only = merge->count() > 0;
    std::erase(arguments->merge, "");
    exit_code = execute(*arguments);
  });
}

}  // namespace slammot
