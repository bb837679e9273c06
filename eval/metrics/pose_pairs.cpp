#include "eval/metrics/pose_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slammot {
namespace {

double shortest_interval(const std::vector<Frame>& frames) {
  double shortest = std::numeric_limits<double>::infinity();
  for (size_t i = 1; i < frames.size(); ++i) {
    shortest = std::min(shortest, frames[i].timestamp - frames[i - 1].timestamp);
  }
  return shortest;
}

size_t nearest_frame(const std::vector<Frame>& frames, double timestamp) {
  const auto later =
      std::lower_bound(frames.begin(), frames.end(), timestamp,
                       [](const Frame& frame, double t) { return frame.timestamp < t; });
  if (later == frames.begin()) return 0;
  const size_t before = static_cast<size_t>(later - frames.begin()) - 1;
  if (later == frames.end()) return before;
  return timestamp - frames[before].timestamp <= later->timestamp - timestamp ? before : before + 1;
}

}  // namespace

std::vector<PosePair> pair_with_truth(const Sequence& sequence,
                                      const std::vector<CameraEstimate>& estimates) {
  std::vector<PosePair> pairs;
  if (sequence.frames.empty() || sequence.truth.size() != sequence.frames.size()) return pairs;
  const double tolerance = shortest_interval(sequence.frames) / 2.0;
  for (const CameraEstimate& estimate : estimates) {
    const size_t i = nearest_frame(sequence.frames, estimate.timestamp);
    const Frame& frame = sequence.frames[i];
    if (!sequence.truth[i] || std::abs(frame.timestamp - estimate.timestamp) > tolerance) continue;
    pairs.push_back({frame.index, estimate, *sequence.truth[i]});
  }
  return pairs;
}

}  // namespace slammot
