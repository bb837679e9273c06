#include "eval/run/evaluate.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "datasets/readers/reader.h"
#include "datasets/sequence/sequence_hints.h"
#include "eval/configuration/registry.h"
#include "eval/metrics/labels/label_truth.h"
#include "eval/output/run_files.h"
#include "eval/run/alternatives.h"
#include "eval/run/self_check.h"
#include "eval/trajectory/trajectory_file.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

// The sequence judged against decides what is true, not the file of the run.
void take_truth_from(const Sequence& sequence, RunResult& run) {
  const std::vector<PosePair> pairs = pair_with_truth(sequence, run.filtered);
  const int last = pairs.empty() ? std::numeric_limits<int>::max() : pairs.back().frame;
  const std::map<int, Label> truths = labels_when_last_measured(sequence, last);
  for (ClassificationRecord& record : run.classification) {
    const auto truth = truths.find(record.track);
    record.truth.reset();
    if (truth != truths.end()) record.truth = truth->second;
  }
}

Path resolved(const Path& path) {
  std::error_code ignored;
  const Path whole = std::filesystem::weakly_canonical(path, ignored);
  return whole.has_filename() ? whole : whole.parent_path();
}

// `seed-07` of `dead_reckoning-07`: runs whose names differ by a number are of one estimator.
std::string without_number(std::string name) {
  const size_t digits = name.find_last_not_of("0123456789");
  if (digits == std::string::npos) return "";
  name.resize(digits + 1);
  const size_t end = name.find_last_not_of("-_. ");
  name.resize(end == std::string::npos ? 0 : end + 1);
  return name;
}

std::string estimator_name(const Path& path, const StoredRun& stored) {
  if (!stored.estimator.empty()) return stored.estimator;
  const std::string name = without_number(run_name(path));
  return name.empty() ? run_name(resolved(path).parent_path()) : name;
}

void convert_covariances(const ErrorConvention& convention, std::vector<CameraEstimate>& cameras) {
  for (CameraEstimate& camera : cameras) {
    auto P = camera.covariance.topLeftCorner<6, 6>();
    P = to_our_error(P, convention, camera.state);
  }
}

// A folder's trajectories, or a file's one; covariances as they are written.
StoredRun read_any(const Path& path, const Sequence& sequence) {
  StoredRun stored;
  if (std::filesystem::is_directory(path)) {
    stored = read_run(path);
    stored.run.batch = stored.own && is_batch(stored.estimator);
    if (!has_models(stored.estimator)) stored.landmark = "-";
    if (stored.own) return stored;
  } else {
    stored.run.filtered = read_trajectory(path, sequence.frames);
  }
  stored.run.frames_offered = static_cast<int>(sequence.frames.size());
  return stored;
}

// Returns the median difference of their times, in seconds.
double place_in_time(const Sequence& sequence, const TimeMatching& times, RunResult& run) {
  PlacedEstimates placed = at_frames(run.filtered, sequence.frames, times);
  run.filtered = std::move(placed.estimates);
  run.frames = std::move(placed.frames);
  for (auto* path : {&run.smoothed, &run.last_scale}) {
    if (!path->empty()) *path = at_frames(*path, sequence.frames, times).estimates;
  }
  return placed.median_difference;
}

// Accuracy and NEES are over the frames that have a pose: few can hide a large error.
std::optional<std::string> few_poses(const Sequence& sequence, const RunResult& run,
                                     const std::string& clue) {
  if (run.frames.empty() || !covers_few(run.frames.size(), sequence.frames.size())) return {};
  return fmt::format("{} of {} frames have a pose, and only these are judged{}", run.frames.size(),
                     sequence.frames.size(), clue);
}

// A pose is compared with the truth of its frame, however far from it in time.
std::optional<std::string> times_differ(const Sequence& sequence, double median_difference) {
  constexpr double kRounded = 0.05;  // of an interval, as milliseconds at 50 Hz
  const double interval = shortest_interval(sequence.frames);
  if (!(median_difference > kRounded * interval)) return {};
  return fmt::format(
      "the times of poses and frames differ by {:.3g} s (median), of {:.3g} s between frames; see "
      "--time-offset",
      median_difference, interval);
}

// A run of this program may have said it already.
void add_new(const std::optional<RunWarning>& warning, std::vector<RunWarning>& warnings) {
  const auto known = [&](const RunWarning& w) { return w.reason == warning->reason; };
  if (!warning || std::ranges::any_of(warnings, known)) return;
  warnings.insert(warnings.begin(), *warning);
}

void add_hint(const std::optional<std::string>& hint, std::vector<RunWarning>& warnings) {
  if (hint) add_new(RunWarning{std::nullopt, *hint}, warnings);
}

// What another program may have written otherwise than it is read; then covariances become ours.
void take_as_stated(const Sequence& sequence, const ErrorConvention& convention, RunResult& run) {
  const std::vector<PosePair> as_written = pair_with_truth(sequence, run.filtered);
  if (sequence.exact_truth) add_hint(other_covariances(as_written, convention), run.warnings);
  add_hint(other_poses(as_written, sequence.exact_truth), run.warnings);
  convert_covariances(convention, run.filtered);
  convert_covariances(convention, run.smoothed);
}

// The same of poses that are not judged where they are: a body's, whose covariances are about its
// error, and those that are aligned.
void take_as_moved(const Sequence& sequence, const ErrorConvention& convention,
                   const JudgeOptions& options, RunResult& run) {
  for (auto* cameras : {&run.filtered, &run.smoothed}) {
    convert_covariances(convention, *cameras);
    if (!options.foreign.T_body_camera) continue;
    for (CameraEstimate& camera : *cameras) to_camera(*options.foreign.T_body_camera, camera);
  }
  // What is to be aligned is in nobody's world, as of measured truth.
  const bool in_true_world = sequence.exact_truth && options.align == AlignBy::kNone;
  add_hint(other_poses(pair_with_truth(sequence, run.filtered), in_true_world), run.warnings);
  align_run(sequence, options.align, run);
}

// Brings the poses to the frames and says what of them is hardly meant.
void hint_at(const Path& path, const Sequence& sequence, const JudgeOptions& options,
             StoredRun& stored) try {
  const ForeignOptions& foreign = options.foreign;
  RunResult& run = stored.run;
  const std::string clue =
      unit_clue(run.filtered.front().timestamp, run.filtered.back().timestamp, sequence.frames);
  const double difference =
      place_in_time(sequence, stored.own ? TimeMatching{} : foreign.times, run);
  take_truth_from(sequence, run);
  if (stored.own) {
    align_run(sequence, options.align, run);
  } else {
    const bool is_folder = std::filesystem::is_directory(path);
    const ErrorConvention stated =
        is_folder ? stored.convention.value_or(foreign.convention) : ErrorConvention{};
    if (foreign.T_body_camera || options.align != AlignBy::kNone) {
      take_as_moved(sequence, stated, options, run);
    } else {
      take_as_stated(sequence, stated, run);
    }
  }
  add_new(covariance_warning(run), run.warnings);
  add_hint(few_poses(sequence, run, clue), run.warnings);
  add_hint(times_differ(sequence, difference), run.warnings);
  for (const std::string& hint : sequence.hints) add_hint(hint, run.warnings);
} catch (const std::invalid_argument& error) {
  throw InputError(path, 0, error.what());
}

// `against`, or what the run says that it was made from.
Path sequence_of(const Path& run, const std::optional<Path>& against) {
  std::optional<Path> path = against;
  if (!path && std::filesystem::is_directory(run)) path = read_run(run).sequence;
  if (!path) throw InputError(run, 0, "names no sequence: give one with --against");
  if (!against && !std::filesystem::exists(*path)) {
    throw InputError(run / run_files::kDescription, 0,
                     "its sequence " + path->string() + " is not there: give it with --against");
  }
  return *path;
}

std::optional<std::string> other_sequence(const StoredRun& stored, const Sequence& sequence) {
  if (stored.sequence_sha256.empty() || stored.sequence_sha256 == sequence.sha256) return {};
  return fmt::format("was made from a sequence with SHA-256 {:.8}.., but {} has {:.8}..",
                     stored.sequence_sha256, sequence.folder.string(), sequence.sha256);
}

}  // namespace

std::string run_name(const Path& run) {
  const Path path = resolved(run);
  const bool file = std::filesystem::is_regular_file(path);
  const std::string name = (file ? path.stem() : path.filename()).string();
  return name.empty() ? "run" : printable(name);
}

std::shared_ptr<const Sequence> Judge::sequence_at(const Path& path) {
  std::shared_ptr<const Sequence>& sequence = sequences_[path];
  if (!sequence) sequence = std::make_shared<const Sequence>(read_sequence(path));
  return sequence;
}

JudgedRun Judge::operator()(const Path& run, const std::optional<Path>& against) {
  if (!std::filesystem::exists(run)) throw InputError(run, 0, "no such run");
  for (const char* mark : {"compare.json", "results.jsonl"}) {
    if (!std::filesystem::exists(run / mark)) continue;
    throw InputError(run, 0, "is no run, but has many; `slammot report` takes it by itself alone");
  }
  JudgedRun judged;
  judged.path = run;
  judged.sequence = sequence_at(sequence_of(run, against));
  judged.stored = read_any(run, *judged.sequence);
  const auto other = other_sequence(judged.stored, *judged.sequence);
  if (other && !options_.force_sequence) {
    throw InputError(run / run_files::kDescription, 0,
                     *other + "; --force-sequence judges it all the same");
  }
  hint_at(run, *judged.sequence, options_, judged.stored);
  add_hint(other, judged.stored.run.warnings);
  judged.estimator = estimator_name(run, judged.stored);
  judged.metrics =
      compute_metrics(*judged.sequence, judged.stored.run, judged.stored.gate_probability);
  return judged;
}

}  // namespace slammot
