#include "datasets/sequence/sequence_hints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/sequence/plausible.h"

namespace slammot {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kLongestStep = 10.0;  // [s], between two frames of one camera
constexpr double kSigmas = 10.0;       // that a statement is off

bool same_measurements(const Frame& a, const Frame& b) {
  return std::ranges::equal(a.observations, b.observations, [](const auto& x, const auto& y) {
    return x.track == y.track && x.pixel == y.pixel;
  });
}

// A camera that truly stands may measure the same without noise.
bool truly_stands(const Sequence& sequence, std::size_t i) {
  if (sequence.truth.size() != sequence.frames.size()) return false;
  const auto &before = sequence.truth[i - 1], &now = sequence.truth[i];
  return before && now && before->position == now->position &&
         before->orientation.coeffs() == now->orientation.coeffs();
}

Hints frozen_frames(const Sequence& sequence) {
  constexpr std::size_t kFewest = 5;  // measurements: fewer may repeat by chance
  Hints hints;
  const std::vector<Frame>& frames = sequence.frames;
  const auto repeats = [&](std::size_t i) {
    return i < frames.size() && frames[i].observations.size() >= kFewest &&
           same_measurements(frames[i - 1], frames[i]) && !truly_stands(sequence, i);
  };
  for (std::size_t i = 1; i < frames.size(); ++i) {
    if (!repeats(i)) continue;
    const std::size_t first = i;
    while (repeats(i + 1)) ++i;
    if (first == 1 && i + 1 == frames.size()) break;  // nothing ever moves
    const int from = frames[first].index, to = frames[i].index;
    hints.push_back(
        fmt::format("{} exactly what frame {} does, to the last digit: are the images frozen?",
                    first == i ? fmt::format("frame {} measures", from)
                               : fmt::format("frames {} to {} measure", from, to),
                    frames[first - 1].index));
  }
  constexpr std::size_t kMost = 3;
  if (hints.size() <= kMost) return hints;
  const std::size_t more = hints.size() - kMost;
  hints.resize(kMost);
  hints.back() += fmt::format(" {} more such spans", more);
  return hints;
}

Hints first_camera(const Sequence& sequence) {
  constexpr double kLeastTurn = 1.0, kLeastStep = 0.1;  // [deg], [m]
  Hints hints;
  if (!sequence.initial || !sequence.exact_truth || !sequence.truth.front()) return hints;
  const InitialCamera& stated = *sequence.initial;
  const CameraState& truth = *sequence.truth.front();
  const double turn = stated.state.orientation.angularDistance(truth.orientation);
  if (turn > kSigmas * stated.rotation_sigma && turn * kDegrees > kLeastTurn) {
    hints.push_back(fmt::format(
        "initial.yaml: the first rotation is {:.4g} deg from the first true one, stated to {:.3g} "
        "rad; its quaternion is x, y, z, w",
        turn * kDegrees, stated.rotation_sigma));
  }
  const double step = (stated.state.position - truth.position).norm();
  if (step > kSigmas * stated.position_sigma && step > kLeastStep) {
    hints.push_back(fmt::format(
        "initial.yaml: the first position is {:.4g} m from the first true one, stated to {:.3g} m",
        step, stated.position_sigma));
  }
  return hints;
}

}  // namespace

std::string unit_clue(double first, double last, const std::vector<Frame>& frames) {
  constexpr double kLonger = 1.5;
  const double begin = frames.front().timestamp, end = frames.back().timestamp;
  const double span = end - begin;
  for (const TimeUnit& unit : kTimeUnits) {
    const double from = first * unit.per_second, to = last * unit.per_second;
    const bool alike = to - from < kLonger * span && span < kLonger * (to - from);
    if (last < begin && from <= end && to >= begin && alike) {
      return fmt::format("; are these too small by a factor of {:g}?", unit.per_second);
    }
  }
  if (!(last - first > kLonger * span)) return "";
  for (const TimeUnit& unit : kTimeUnits) {
    const double from = first / unit.per_second, to = last / unit.per_second;
    const bool overlaps = from <= end && to >= begin;
    if (overlaps && to - from < kLonger * span) return fmt::format("; are these {}?", unit.name);
  }
  return "";
}

Hints frame_hints(const Sequence& sequence) {
  Hints hints = frozen_frames(sequence);
  const double step = median_interval(sequence.frames);
  if (std::isfinite(step) && step > kLongestStep) {
    hints.push_back(fmt::format("frames are {:.4g} s apart (median); are their times {}?", step,
                                unit_of_time(step, 1.0).name));
  }
  for (std::string& hint : first_camera(sequence)) hints.push_back(std::move(hint));
  return hints;
}

std::optional<std::string> prior_hint(const Sequence& sequence) {
  std::map<int, double> unseen = sequence.p_static;
  for (const Frame& frame : sequence.frames) {
    for (const Observation& z : frame.observations) unseen.erase(z.track);
  }
  if (2 * unseen.size() < sequence.p_static.size() || unseen.empty()) return std::nullopt;
  return fmt::format("priors.csv: {} of {} tracks, as track {}, are measured in no frame",
                     unseen.size(), sequence.p_static.size(), unseen.begin()->first);
}

}  // namespace slammot
