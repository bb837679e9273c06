#include "eval/run/self_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "eval/metrics/nees.h"
#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

// Sums over this many frames: long enough that a few bad frames are none, short enough that a good
// start does not hide a bad end. A shorter run is judged as a whole.
constexpr size_t kFrames = 30;
constexpr size_t kShortestRun = 10;      // of a sum that is shorter
constexpr size_t kBurst = 5;             // and over these: a sudden loss, before tracks begin anew
constexpr int kLeastMeasurements = 100;  // of a sum, else it says nothing
constexpr int kLeastOfBurst = 30;

constexpr double kNisOfOne = 2.0;   // the joint NIS of a consistent estimator, a measurement
constexpr double kTooMuch = 2.0;    // times that: the stated noise is too small, or the path wrong
constexpr double kTooLittle = 0.1;  // times that: the stated noise is three times too large
constexpr int kLeastLasting = 30;   // sums of a run
constexpr double kMostRejected = 0.15;  // a gate rejects a twentieth of right matches
constexpr double kMostRejectedOfBurst = 0.5;
constexpr int kLeastStatic = 5;  // used; three hold a camera, four cannot tell which is wrong
constexpr double kLeastShareStatic = 0.1;
constexpr int kMovingToStatic = 2;  // landmarks; good runs among many movers have as many of each
constexpr int kLeastLabels = 20;
constexpr double kLeastSpread = 3.0;      // of the rays; noise alone spreads those of a line by 1
constexpr double kExplains = 0.8;         // of what the five-point estimate does
constexpr std::size_t kMostWrong = 5;     // one span in so many
constexpr std::size_t kLeastWrong = 2;    // spans
constexpr double kLongestInterval = 5.0;  // between two frames, in usual ones

struct Sums {
  size_t frames = 0, with_few_static = 0;
  int accepted = 0, accepted_static = 0, offered = 0;
  double joint_nis = 0.0;
  int lasting_sums = 0;
  double lasting_nis = 0.0;

  double rejected() const {
    return offered == 0 ? 0.0 : 1.0 - static_cast<double>(accepted) / offered;
  }
};

Sums sums_of(const std::vector<FrameCounts>& counts, size_t first, size_t frames) {
  Sums sums{.frames = frames};
  for (size_t i = first; i < first + frames; ++i) {
    const FrameCounts& c = counts[i];
    sums.accepted += c.accepted;
    sums.accepted_static += c.accepted_static;
    sums.offered += c.accepted + c.rejected + c.out_of_view;
    sums.with_few_static += c.accepted > 0 && c.accepted_static < kLeastStatic ? 1 : 0;
    sums.joint_nis += c.joint_nis;
    sums.lasting_sums += c.lasting_sums;
    sums.lasting_nis += c.lasting_nis;
  }
  return sums;
}

using Test = std::function<std::optional<std::string>(const Sums&)>;

// Frames of a sum: all of a run that has fewer than asked for. Of too few nothing is said.
std::optional<size_t> length_of_sums(size_t run, size_t asked) {
  if (run < std::min(asked, kShortestRun)) return std::nullopt;
  return std::min(run, asked);
}

// The first frame of the first sum over so many frames that fails.
std::optional<RunWarning> first_failure(const RunResult& run, size_t asked, const Test& test) {
  const auto frames = length_of_sums(run.counts.size(), asked);
  if (!frames) return std::nullopt;
  for (size_t i = 0; i + *frames <= run.counts.size(); ++i) {
    if (const auto reason = test(sums_of(run.counts, i, *frames))) {
      return RunWarning{run.frames[i], *reason};
    }
  }
  return std::nullopt;
}

std::optional<std::string> noise_is_wrong(const Sums& s) {
  if (s.accepted < kLeastMeasurements) return std::nullopt;
  const double nis = s.joint_nis / s.accepted;
  if (!(nis > kTooMuch * kNisOfOne)) return std::nullopt;  // nor one that is not stated
  return fmt::format(
      "joint NIS {:.1f} where {:.0f} is right, over {} frames: the stated noise is too small, or "
      "the estimate wrong",
      nis, kNisOfOne, s.frames);
}

// Of the whole run: a noise that is too large loses nobody, and is the same in all frames.
std::optional<RunWarning> noise_is_too_large(const RunResult& run) {
  const Sums s = sums_of(run.counts, 0, run.counts.size());
  if (s.accepted < kLeastMeasurements) return std::nullopt;
  const double nis = s.joint_nis / s.accepted;
  if (!(nis > 0.0 && nis < kTooLittle * kNisOfOne)) return std::nullopt;  // nor unstated
  return RunWarning{run.frames.front(),
                    fmt::format("joint NIS {:.2g} where {:.0f} is right, over the whole run: the "
                                "stated noise of the pixels is more than three times too large, "
                                "and so are the covariances",
                                nis, kNisOfOne)};
}

// Of the whole run. A frame's own NIS is right where sigma is, and a covariance that takes each
// error for new is not, where errors last.
std::optional<RunWarning> errors_last(const RunResult& run) {
  const Sums s = sums_of(run.counts, 0, run.counts.size());
  if (s.lasting_sums < kLeastLasting) return std::nullopt;
  const double nis = s.lasting_nis / s.lasting_sums;
  if (!(nis > kTooMuch * kNisOfOne)) return std::nullopt;
  return RunWarning{
      run.frames.front(),
      fmt::format(
          "NIS {:.1f} of the sum of 30 innovations of a track where {:.0f} is right, over "
          "the whole run: errors last from frame to frame (tracks that drift, a lens, a mount "
          "or a motion stated wrongly), and covariances that take them for new are too small",
          nis, kNisOfOne)};
}

std::string rejected_text(const Sums& s) {
  return fmt::format("{:.0f}% of the measurements of {} frames were rejected or out of view",
                     100.0 * s.rejected(), s.frames);
}

std::optional<std::string> many_are_rejected(const Sums& s) {
  if (s.offered < kLeastMeasurements || s.rejected() <= kMostRejected) return std::nullopt;
  return rejected_text(s) + ": wrong matches, or the estimate is wrong";
}

std::optional<std::string> most_are_rejected_at_once(const Sums& s) {
  if (s.offered < kLeastOfBurst || s.rejected() <= kMostRejectedOfBurst) return std::nullopt;
  return rejected_text(s) + " at once: it did not see what it expected";
}

std::optional<std::string> nothing_is_used(const Sums& s) {
  if (s.accepted > 0 || std::isnan(s.joint_nis)) return std::nullopt;  // used, or not stated
  return fmt::format("no measurement was used for {} frames", s.frames);
}

std::optional<std::string> hardly_any_is_static(const Sums& s) {
  if (s.accepted == 0) return std::nullopt;
  if (2 * s.with_few_static > s.frames) {
    return fmt::format("fewer than {} static landmarks in view in {} of {} frames", kLeastStatic,
                       s.with_few_static, s.frames);
  }
  if (s.accepted_static >= kLeastShareStatic * s.accepted) return std::nullopt;
  return fmt::format("{:.0f}% of the measurements used in {} frames are of static landmarks",
                     100.0 * s.accepted_static / s.accepted, s.frames);
}

// By their last labels: of what was decided, neither known beforehand nor static by rule.
std::optional<RunWarning> labels_have_collapsed(const RunResult& run) {
  const auto called = [&](Label label) {
    return std::ranges::count_if(run.landmarks, [&](const LandmarkRecord& landmark) {
      return !landmark.estimate.by_rule && landmark.estimate.label == label;
    });
  };
  const auto moving = called(Label::kMoving);
  const auto resting = called(Label::kStatic);
  if (moving + resting < kLeastLabels || moving <= kMovingToStatic * resting) return std::nullopt;
  return RunWarning{
      run.frames.front(),
      fmt::format("of the {} landmarks called static or moving, over the whole run, {} are called "
                  "moving: unless most do move, the labels have collapsed",
                  moving + resting, moving)};
}

// A frame that measures landmarks, none of them static, after one that measured enough: then
// nothing ties the camera to the map before, and labels that come later agree with whatever it did.
std::optional<RunWarning> nothing_static(const RunResult& run) {
  bool has_seen = false;
  for (std::size_t i = 0; i < run.counts.size(); ++i) {
    const FrameCounts& c = run.counts[i];
    if (has_seen && c.accepted > 0 && c.accepted_static == 0) {
      return RunWarning{run.frames[i],
                        "of the landmarks in view none is static: what was taken to be at rest "
                        "was lost or set free, and nothing ties the camera to the map before"};
    }
    has_seen = has_seen || c.accepted_static >= kLeastStatic;
  }
  return std::nullopt;
}

// Through frames in most of which all that it used lies on one line of the image, or in one point.
std::optional<RunWarning> all_on_one_line(const RunResult& run) {
  const auto frames = length_of_sums(run.ray_spread.size(), kFrames);
  if (!frames) return std::nullopt;
  for (std::size_t i = 0; i + *frames <= run.ray_spread.size(); ++i) {
    const auto thin = std::ranges::count_if(std::span(run.ray_spread).subspan(i, *frames),
                                            [](double spread) { return spread < kLeastSpread; });
    if (2 * static_cast<std::size_t>(thin) <= *frames) continue;
    return RunWarning{run.frames[i],
                      fmt::format("in {} of {} frames the static landmarks in view lie on one "
                                  "line of the image: if they do in space, a turn about it is not "
                                  "seen",
                                  thin, *frames)};
  }
  return std::nullopt;
}

// Nobody sees what the camera does meanwhile, and its motion model alone bridges it.
std::optional<RunWarning> time_jumps(const RunResult& run) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < run.filtered.size(); ++i) {
    intervals.push_back(run.filtered[i].timestamp - run.filtered[i - 1].timestamp);
  }
  const double usual = median(intervals);
  const auto jump = std::ranges::find_if(
      intervals, [&](double interval) { return interval > kLongestInterval * usual; });
  if (jump == intervals.end()) return std::nullopt;
  return RunWarning{run.frames[static_cast<std::size_t>(jump - intervals.begin()) + 1],
                    fmt::format("no frame for {:.2g} s, {:.0f} times the usual interval: only the "
                                "motion model bridges it",
                                *jump, *jump / usual)};
}

bool disagrees(const RotationSpan& s) { return s.estimate < kExplains * s.five_point; }

// An object that fills the view spoils a few spans of a good run, so a share of them is asked for.
std::optional<RunWarning> rotation_is_wrong(std::span<const RotationSpan> spans) {
  std::vector<double> angles;
  int first = 0;
  for (const RotationSpan& s : spans) {
    if (!disagrees(s)) continue;
    if (angles.empty()) first = s.first;
    angles.push_back(s.angle);
  }
  const std::size_t wrong = angles.size();
  if (wrong < kLeastWrong || kMostWrong * wrong <= spans.size()) return std::nullopt;
  std::ranges::nth_element(angles, angles.begin() + static_cast<std::ptrdiff_t>(wrong / 2));
  return RunWarning{first,
                    fmt::format("rotation disagrees with a five-point estimate: in {} of {} spans "
                                "of at most ten frames, by {:.2g} degrees (median)",
                                wrong, spans.size(), angles[wrong / 2] * 180.0 / std::numbers::pi)};
}

}  // namespace

std::optional<RunWarning> covariance_warning(const RunResult& run) {
  const std::vector<CameraEstimate>& cameras = run.judged();
  int stated = 0, wrong = 0, first = 0;
  // But for the first, which may be a pin and is left out of the NEES.
  for (std::size_t i = 1; i < std::min(cameras.size(), run.frames.size()); ++i) {
    const auto& P = cameras[i].covariance;
    bool states = false, fails = false;
    for (const auto& [begin, size] : {std::pair{kPosition, 6}, {kPosition, 3}, {kRotation, 3}}) {
      const auto block = P.block(begin, begin, size, size);
      if (block.hasNaN()) continue;  // not stated
      states = true;
      fails = fails || !is_positive_definite(block);
    }
    stated += states;
    if (fails && wrong++ == 0) first = run.frames[i];
  }
  if (wrong == 0) return std::nullopt;
  return RunWarning{first, fmt::format("covariances of the pose that are not positive definite: "
                                       "{} of {}",
                                       wrong, stated)};
}

std::vector<RunWarning> self_check(const RunResult& run, std::span<const RotationSpan> rotations,
                                   const std::optional<StatedScale>& scale) {
  std::vector<RunWarning> warnings;
  const auto check = [&](size_t frames, const Test& test) {
    if (auto warning = first_failure(run, frames, test)) warnings.push_back(std::move(*warning));
  };
  check(kFrames, noise_is_wrong);
  check(kFrames, many_are_rejected);
  check(kBurst, most_are_rejected_at_once);
  check(kFrames, nothing_is_used);
  check(kFrames, hardly_any_is_static);
  if (auto warning = noise_is_too_large(run)) warnings.push_back(std::move(*warning));
  if (auto warning = errors_last(run)) warnings.push_back(std::move(*warning));
  if (auto warning = labels_have_collapsed(run)) warnings.push_back(std::move(*warning));
  if (auto warning = nothing_static(run)) warnings.push_back(std::move(*warning));
  if (auto warning = all_on_one_line(run)) warnings.push_back(std::move(*warning));
  if (auto warning = time_jumps(run)) warnings.push_back(std::move(*warning));
  if (auto warning = rotation_is_wrong(rotations)) warnings.push_back(std::move(*warning));
  if (auto warning = covariance_warning(run)) warnings.push_back(std::move(*warning));
  if (scale) {
    if (auto warning = scale_warning(run, *scale)) warnings.push_back(std::move(*warning));
  }
  std::ranges::stable_sort(warnings, {}, &RunWarning::frame);
  return warnings;
}

}  // namespace slammot
