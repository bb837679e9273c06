// What goes wrong with a recording, half way: wrong matches, a clock that jumps, frames that
// measure nothing, a camera that is carried away. None of it is stated of the sequence; the truth
// has it.
#pragma once

#include "datasets/sequence/sequence.h"
#include "datasets/simulation/parameters/parameters.h"

namespace slammot {

struct DisturbanceOptions {
  double outliers = 0.0;  // share of all measurements, replaced by pixels anywhere in the image
  double gap = 0.0;       // [s] that the clock jumps, while camera and scene stand still
  double empty = 0.0;     // [s] without measurements, while camera and scene go on
  double teleport =
      0.0;  // [m] that the camera is displaced to its right, from one frame to the next
};
Parameters parameters(DisturbanceOptions& options);

// The teleport, before anything is recorded.
std::vector<CameraState> displaced(const DisturbanceOptions& options,
                                   std::vector<CameraState> trajectory);

// All else, after everything was stated. Throws std::invalid_argument for a share above 1.
void disturb(const DisturbanceOptions& options, std::uint64_t seed, Sequence& sequence);

}  // namespace slammot
