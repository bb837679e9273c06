// Estimated cameras beside the true ones. A frame has at most one estimate, the nearest in time; by
// default within half a frame.
#pragma once

#include <optional>
#include <vector>

#include "datasets/sequence/sequence.h"
#include "estimation/estimator.h"

namespace slammot {

struct PosePair {
  int frame = 0;  // index in the sequence
  CameraEstimate estimate;
  CameraState truth;
};

// How the times of a trajectory made elsewhere are compared with those of the frames.
struct TimeMatching {
  double offset = 0.0;                   // [s], added to the estimate's
  std::optional<double> max_difference;  // [s]
};

struct PlacedEstimates {
  std::vector<CameraEstimate> estimates;  // at the times of their frames
  std::vector<int> frames;                // indices
  double median_difference = 0.0;         // [s], of their own times from those of the frames
};

// The estimate of each frame that has one. Throws std::invalid_argument where no frame has one.
PlacedEstimates at_frames(const std::vector<CameraEstimate>& estimates,
                          const std::vector<Frame>& frames, const TimeMatching& matching);

// Whether fewer than half of the frames have a pose: what is known of these is not the run's.
constexpr bool covers_few(std::size_t poses, std::size_t frames) { return 2 * poses < frames; }

// [s]; infinite of fewer than two frames.
double shortest_interval(const std::vector<Frame>& frames);

// Estimates without a true pose near in time are left out.
std::vector<PosePair> pair_with_truth(const Sequence& sequence,
                                      const std::vector<CameraEstimate>& estimates);

}  // namespace slammot
