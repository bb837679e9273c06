#include "apps/support/judge_options.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/text/text_table.h"
#include "eval/output/run_files.h"

namespace slammot {

void add_judge_options(CLI::App& command, JudgeArguments& arguments) {
  command
      .add_option(
          "--against", arguments.against,
          "the sequence with the truth: once for all runs, or repeated for each in their order; "
          "without it, that of run.yaml")
      ->type_name("SEQUENCE")
      ->allow_extra_args(false);
  command
      .add_option("--error-convention", arguments.convention,
                  "of a pose_covariance.csv made elsewhere: position-first|rotation-first, "
                  "right|left, global|local|spatial (docs/judge.md); one for all runs of a call")
      ->type_name("ORDER,ROTATION,POSITION")
      ->capture_default_str();
  command
      .add_option("--extrinsics", arguments.extrinsics,
                  "of poses of a body made elsewhere: a file with T_BC, the camera in the body, as "
                  "tx ty tz qx qy qz qw")
      ->type_name("FILE");
  command
      .add_option("--align", arguments.align,
                  "before errors and NEES, to the truth: by the first pose, or a fit of all "
                  "positions (none)")
      ->check(CLI::IsMember(kAlignments));
  command
      .add_option("--time-offset", arguments.time_offset,
                  "added to the times of runs made elsewhere")
      ->type_name("SECONDS");
  command
      .add_option("--max-difference", arguments.max_difference,
                  "between a pose made elsewhere and its frame; without it, half a frame")
      ->type_name("SECONDS")
      ->check(CLI::PositiveNumber);
  command.add_flag("--force-sequence", arguments.force_sequence,
                   "judge a run against another sequence than the one it was made from");
  command.add_flag("--force", arguments.force, "replace an earlier output");
}

namespace {

// An option that changes nothing was meant to change something.
void refuse_idle_options(const JudgeArguments& arguments, const std::vector<JudgedRun>& runs) {
  const bool stated = arguments.convention != JudgeArguments{}.convention ||
                      !arguments.extrinsics.empty() || arguments.time_offset != 0.0 ||
                      arguments.max_difference > 0.0;
  const bool all_own = std::ranges::all_of(runs, [](const auto& run) { return run.stored.own; });
  if (stated && all_own) {
    throw std::invalid_argument(
        "--error-convention, --extrinsics, --time-offset and --max-difference are for runs made "
        "elsewhere: these "
        "are slammot's own, or stored by `report`, which has converted them");
  }
  const bool converted = std::ranges::any_of(runs, [](const auto& run) {
    return !run.stored.own && is_there(run.path / run_files::kPoseCovariance);
  });
  if (arguments.convention != JudgeArguments{}.convention && !converted) {
    throw std::invalid_argument(
        "--error-convention is of a pose_covariance.csv made elsewhere: no run has one");
  }
}

}  // namespace

std::vector<JudgedRun> judged(const JudgeArguments& arguments) {
  const std::size_t sequences = arguments.against.size();
  if (sequences > 1 && sequences != arguments.runs.size()) {
    throw std::invalid_argument("--against: one sequence for all runs, or one for each");
  }
  if (!std::isfinite(arguments.time_offset)) throw std::invalid_argument("--time-offset");
  JudgeOptions options;
  options.foreign.convention = parse_error_convention(arguments.convention);
  options.foreign.times.offset = arguments.time_offset;
  if (arguments.max_difference > 0.0) {
    options.foreign.times.max_difference = arguments.max_difference;
  }
  if (!arguments.extrinsics.empty()) {
    options.foreign.T_body_camera = read_extrinsics(arguments.extrinsics);
  }
  options.align = kAlignments.at(arguments.align);
  options.force_sequence = arguments.force_sequence;
  Judge judge(options);
  std::vector<JudgedRun> runs;
  for (std::size_t i = 0; i < arguments.runs.size(); ++i) {
    std::optional<std::filesystem::path> against;
    if (sequences > 0) against = arguments.against[sequences == 1 ? 0 : i];
    runs.push_back(judge(arguments.runs[i], against));
  }
  refuse_idle_options(arguments, runs);
  return runs;
}

}  // namespace slammot
