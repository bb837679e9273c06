#include "eval/run/self_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace slammot {
namespace {

// Sums over this many frames: long enough that a few bad frames are none, short enough that a good
// start does not hide a bad end.
constexpr size_t kFrames = 30;
constexpr int kLeastMeasurements = 100;  // of a sum, else it says nothing
constexpr int kLeastDecided = 20;        // labels

constexpr double kNisOfOne = 2.0;  // the joint NIS of a consistent estimator, a measurement
constexpr double kTooMuch = 2.0;   // times that: the stated noise is too small, or the path wrong
constexpr double kMostRejected = 0.5;
constexpr double kExplains = 0.5;       // of what the five-point estimate does
constexpr std::size_t kMostWrong = 5;   // one span in so many
constexpr std::size_t kLeastWrong = 2;  // spans
constexpr int kLeastStatic = 4;         // in view; fewer do not hold a camera

struct Sums {
  int accepted = 0, offered = 0, most_static = 0;
  double joint_nis = 0.0;
};

Sums sums_of(const std::vector<FrameCounts>& counts, size_t first) {
  Sums sums;
  for (size_t i = first; i < first + kFrames; ++i) {
    const FrameCounts& c = counts[i];
    sums.accepted += c.accepted;
    sums.offered += c.accepted + c.rejected + c.out_of_view;
    sums.most_static = std::max(sums.most_static, c.accepted_static);
    sums.joint_nis += c.joint_nis;
  }
  return sums;
}

using Test = std::function<std::optional<std::string>(const Sums&)>;

// The first frame of the first sum that fails.
std::optional<RunWarning> first_failure(const RunResult& run, const Test& test) {
  for (size_t i = 0; i + kFrames <= run.counts.size(); ++i) {
    if (const auto reason = test(sums_of(run.counts, i))) return RunWarning{run.frames[i], *reason};
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
      nis, kNisOfOne, kFrames);
}

std::optional<std::string> most_is_rejected(const Sums& s) {
  if (s.offered < kLeastMeasurements) return std::nullopt;
  const double share = 1.0 - static_cast<double>(s.accepted) / s.offered;
  if (share <= kMostRejected) return std::nullopt;
  return fmt::format("{:.0f}% of the measurements of {} frames were rejected or out of view",
                     100.0 * share, kFrames);
}

std::optional<std::string> nothing_is_used(const Sums& s) {
  if (s.accepted > 0 || std::isnan(s.joint_nis)) return std::nullopt;  // used, or not stated
  return fmt::format("no measurement was used for {} frames", kFrames);
}

std::optional<std::string> nothing_is_static(const Sums& s) {
  if (s.accepted == 0 || s.most_static >= kLeastStatic) return std::nullopt;
  return fmt::format("fewer than {} static landmarks in view for {} frames", kLeastStatic, kFrames);
}

// Of the labels that were decided. Where most of a scene does move, nobody else could tell either.
std::optional<RunWarning> labels_have_collapsed(const RunResult& run) {
  int decided = 0, moving = 0;
  int first = 0;
  for (const ClassificationRecord& record : run.classification) {
    if (record.label == Label::kUnknown) continue;
    ++decided;
    if (record.label != Label::kMoving) continue;
    if (moving++ == 0) first = record.decision_frame.value_or(0);
    first = std::min(first, record.decision_frame.value_or(first));
  }
  if (decided < kLeastDecided || 2 * moving <= decided) return std::nullopt;
  return RunWarning{first,
                    fmt::format("{} of {} decided landmarks are called moving", moving, decided)};
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

std::vector<RunWarning> self_check(const RunResult& run, std::span<const RotationSpan> rotations) {
  std::vector<RunWarning> warnings;
  for (const auto& test : {noise_is_wrong, most_is_rejected, nothing_is_used, nothing_is_static}) {
    if (auto warning = first_failure(run, test)) warnings.push_back(std::move(*warning));
  }
  if (auto warning = labels_have_collapsed(run)) warnings.push_back(std::move(*warning));
  if (auto warning = rotation_is_wrong(rotations)) warnings.push_back(std::move(*warning));
  std::ranges::stable_sort(warnings, {}, &RunWarning::frame);
  return warnings;
}

}  // namespace slammot
