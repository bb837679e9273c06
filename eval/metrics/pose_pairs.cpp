#include "eval/metrics/pose_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "datasets/sequence/sequence_hints.h"
#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

size_t nearest_frame(const std::vector<Frame>& frames, double timestamp) {
  const auto later =
      std::lower_bound(frames.begin(), frames.end(), timestamp,
                       [](const Frame& frame, double t) { return frame.timestamp < t; });
  if (later == frames.begin()) return 0;
  const size_t before = static_cast<size_t>(later - frames.begin()) - 1;
  if (later == frames.end()) return before;
  return timestamp - frames[before].timestamp <= later->timestamp - timestamp ? before : before + 1;
}

struct Match {
  size_t frame, estimate;
  double difference;  // [s]
};

// In order of the estimates, whose times increase.
std::vector<Match> matches(const std::vector<CameraEstimate>& estimates,
                           const std::vector<Frame>& frames, double offset, double tolerance) {
  std::vector<Match> found;
  for (size_t k = 0; k < estimates.size() && !frames.empty(); ++k) {
    const double time = estimates[k].timestamp + offset;
    const size_t i = nearest_frame(frames, time);
    const Match match{i, k, std::abs(frames[i].timestamp - time)};
    if (match.difference > tolerance) continue;
    const bool again = !found.empty() && found.back().frame == i;
    if (!again) found.push_back(match);
    if (again && match.difference < found.back().difference) found.back() = match;
  }
  return found;
}

double half_a_frame(const std::vector<Frame>& frames) { return shortest_interval(frames) / 2.0; }

}  // namespace

double shortest_interval(const std::vector<Frame>& frames) {
  double shortest = std::numeric_limits<double>::infinity();
  for (size_t i = 1; i < frames.size(); ++i) {
    shortest = std::min(shortest, frames[i].timestamp - frames[i - 1].timestamp);
  }
  return shortest;
}

PlacedEstimates at_frames(const std::vector<CameraEstimate>& estimates,
                          const std::vector<Frame>& frames, const TimeMatching& matching) {
  const double tolerance = matching.max_difference.value_or(half_a_frame(frames));
  PlacedEstimates placed;
  std::vector<double> differences;
  for (const Match& match : matches(estimates, frames, matching.offset, tolerance)) {
    placed.estimates.push_back(estimates[match.estimate]);
    placed.estimates.back().timestamp = frames[match.frame].timestamp;
    placed.frames.push_back(frames[match.frame].index);
    differences.push_back(match.difference);
  }
  if (!differences.empty()) placed.median_difference = median(differences);
  if (placed.frames.empty() && !estimates.empty() && !frames.empty()) {
    throw std::invalid_argument(fmt::format(
        "no pose is within {:.3g} s of a frame: poses from {:.13g} to {:.13g} s, frames from "
        "{:.13g} to {:.13g} s{}",
        tolerance, estimates.front().timestamp + matching.offset,
        estimates.back().timestamp + matching.offset, frames.front().timestamp,
        frames.back().timestamp,
        unit_clue(estimates.front().timestamp, estimates.back().timestamp, frames)));
  }
  return placed;
}

std::vector<PosePair> pair_with_truth(const Sequence& sequence,
                                      const std::vector<CameraEstimate>& estimates) {
  std::vector<PosePair> pairs;
  const std::vector<Frame>& frames = sequence.frames;
  if (sequence.truth.size() != frames.size()) return pairs;
  for (const Match& match : matches(estimates, frames, 0.0, half_a_frame(frames))) {
    const auto& truth = sequence.truth[match.frame];
    if (truth) pairs.push_back({frames[match.frame].index, estimates[match.estimate], *truth});
  }
  return pairs;
}

}  // namespace slammot
