// Scenario `square` (thesis 4.1.1, figure 4.1b): a camera at constant speed on four connected
// lines.
//
// Corners are turned on the move, on an arc of length `turn_length` whose curvature is
// (pi/2 / length) (1 - cos(2 pi w / length)): the speed is constant throughout, acceleration
// smooth. The path starts at the origin, in the middle of a side, along +z, and turns right.
#pragma once

#include "datasets/simulation/scene/volume.h"

namespace slammot {

struct SquareOptions {
  SceneOptions scene;
  double side = 20.0;  // between the lines of opposite sides [m]
  int loop_frames = 450;
  double turn_length = 4.0;  // [m]
};
Parameters parameters(SquareOptions& options);

Sequence simulate_square(const SquareOptions& options, std::uint64_t seed);

}  // namespace slammot
