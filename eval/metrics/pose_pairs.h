// Estimated cameras beside the true ones, matched by the nearest timestamp within half a frame.
#pragma once

#include <vector>

#include "datasets/sequence/sequence.h"
#include "estimation/estimator.h"

namespace slammot {

struct PosePair {
  int frame = 0;  // index in the sequence
  CameraEstimate estimate;
  CameraState truth;
};

// Estimates without a true pose near in time are left out.
std::vector<PosePair> pair_with_truth(const Sequence& sequence,
                                      const std::vector<CameraEstimate>& estimates);

}  // namespace slammot
