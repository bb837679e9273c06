// slammot study STUDY.yaml: scenarios x estimators x swept values x seeds, in parallel.
#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <memory>
#include <thread>

#include "apps/commands.h"
#include "apps/support/command_line.h"
#include "apps/support/progress.h"
#include "apps/support/usage.h"
#include "apps/support/writable.h"
#include "datasets/output/output_files.h"
#include "datasets/text/number.h"
#include "eval/python/report_generator.h"
#include "eval/study/study_driver.h"
#include "eval/study/study_plan.h"
#include "eval/study/study_view.h"
#include "frontend/odometry/rotation_check.h"

namespace slammot {
namespace {

struct StudyArguments {
  std::string study;
  std::string output;
  std::string shard;
  std::vector<std::string> merge;
  std::vector<std::string> settings;
  std::string record_in;
  bool record = false;
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

// Nothing where nothing is to be recorded; without a folder of its own, results/ of the repository
// that the study is in.
RecordOptions record_of(const StudyArguments& arguments) {
  namespace fs = std::filesystem;
  if (!arguments.record) return {};
  const fs::path study = fs::absolute(arguments.study);
  RecordOptions options{arguments.record_in, study.stem().string(), command_line()};
  for (fs::path at = study.parent_path(); options.record.empty(); at = at.parent_path()) {
    if (fs::exists(at / ".git")) options.record = at / "results";
    if (at == at.root_path()) break;
  }
  if (options.record.empty()) {
    throw std::invalid_argument("--record: " + arguments.study +
                                " is in no repository: name a folder, --record DIR");
  }
  require_writable_folder(options.record);
  return options;
}

int finish(const Study& study, const std::filesystem::path& output,
           const std::vector<std::filesystem::path>& folders, int jobs, bool mix,
           const RecordOptions& record) {
  merge_runs(study, folders, output, mix);
  write_file(output / "plan.json", study_plan(study, provenance(jobs)).dump(1) + '\n');
  write_file(output / "view.json", study_view(study).dump() + '\n');
  if (const int code = make_study_page(output, record); code != 0) {
    if (code == 1) {
      fmt::print(stderr, "slammot: no report; the results are in {}\n", output.string());
    }
    return code;
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

std::string computed_once_text(const Study& study) {
  int others = 0;
  for (int i = 0; i < std::ssize(study.cells); ++i) {
    others += study.cells[static_cast<std::size_t>(i)].computed_by == i ? 0 : 1;
  }
  return others == 0 ? "" : fmt::format(", {} the same as others and computed once", others);
}

// What is written when the program is told to stop: a signal handler may only use what is there.
std::string& last_words() {
  static std::string text;
  return text;
}

extern "C" void stop(int signal) {
  const std::string& text = last_words();
  [[maybe_unused]] const auto written = write(STDERR_FILENO, text.data(), text.size());
  std::signal(signal, SIG_DFL);
  raise(signal);
}

// By Ctrl-C, or by a cluster whose time is up.
void tell_when_stopped(const std::filesystem::path& output, bool resume_must_be_asked) {
  last_words() =
      fmt::format("\nslammot: stopped; the finished runs are kept in {}. To go on: {}{}\n",
                  output.string(), command_line(), resume_must_be_asked ? " --resume" : "");
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, stop);
}

int execute(const StudyArguments& arguments) {
  const Shard shard = parse_shard(arguments.shard);
  const RecordOptions record = record_of(arguments);
  Study study = read_study(arguments.study, arguments.settings);
  if (arguments.runs > 0) study.runs = arguments.runs;
  const std::filesystem::path output =
      arguments.output.empty() ? std::filesystem::path("slammot-out") / ("study-" + study.name)
                               : std::filesystem::path(arguments.output);
  require_writable_folder(output);
  if (arguments.merge_only) {
    claim_folder(study, output, shard, true);
    std::vector<std::filesystem::path> folders(arguments.merge.begin(), arguments.merge.end());
    if (folders.empty()) folders.push_back(output);
    return finish(study, output, folders, 0, arguments.force, record);
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
  fmt::print("{}: {} scenarios and swept values x estimators{}, {}, {} at a time\n", study.name,
             study.cells.size(), computed_once_text(study), runs_text(study), options.jobs);
  std::fflush(stdout);
  tell_when_stopped(output, !resume);
  const auto [ran, kept] = run_study(study, options);
  progress.clear();
  fmt::print("{} runs done{}\n", ran, kept > 0 ? fmt::format(", {} were there", kept) : "");
  if (shard.count == 1) {
    return finish(study, output, {output}, options.jobs, arguments.force, record);
  }
  fmt::print(
      "shard {} of {} is in {}; when all are there: slammot study {}{} --merge --output {}; or, of "
      "a "
      "folder each: --merge DIR1 DIR2 ... --output DIR\n",
      shard.index, shard.count, output.string(), arguments.study,
      arguments.settings.empty()
          ? ""
          : fmt::format(" --set {}", fmt::join(arguments.settings, " --set ")),
      output.string());
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
  command
      ->add_option("--set", arguments->settings,
                   "a configuration key of all cells; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
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
  auto* record =
      command
          ->add_option("--record", arguments->record_in,
                       "also table.md and a short summary.json in DIR/STUDY (results/ of the "
                       "repository), with commit, seeds, command and processor")
          ->type_name("DIR")
          ->expected(0, 1)
          ->excludes(shard);
  command->callback([arguments, merge, record, &exit_code] {
    arguments->merge_only = merge->count() > 0;
    arguments->record = record->count() > 0;
    std::erase(arguments->merge, "");
    exit_code = execute(*arguments);
  });
}

}  // namespace slammot
