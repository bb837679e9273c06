// Scenario `circle` (thesis 4.1.1, figure 4.1a; DESIGN section 6): a camera on a horizontal circle
// at a speed that is never constant, among static and moving points.
//
// From the origin along +z, turning right: with phase s = t / (time of a loop) the angle is
//   2 pi s - variation / cycles * sin(2 pi cycles s),
// so that the speed goes smoothly between (1 - variation) and (1 + variation) times its mean.
#pragma once

#include "datasets/simulation/scene/volume.h"

namespace slammot {

struct CircleOptions {
  SceneOptions scene;
  double radius = 10.0;  // [m]
  int loop_frames = 450;
  double speed_variation = 0.5;
  int speed_cycles = 5;   // a loop
  double bobbing = 0.0;   // amplitude of an up and down, three times a loop [m]
  double view_deg = 0.0;  // viewing direction to the right of the tangent
};
Parameters parameters(CircleOptions& options);

Sequence simulate_circle(const CircleOptions& options, std::uint64_t seed);

}  // namespace slammot
