// Scenario `manoeuvres`: the scene and camera of `circle` with movers half of which turn and brake
// all the time, while the other half keep their velocity.
//
// Nobody stands still: a velocity of zero means a standing object, which is what `move_stop_move`
// is about. The acceleration stated of objects is the RMS of the true one on an axis; a speed goes
// up to sqrt(2.8^2 + 1.6^2) = 3.2 m/s, above what is stated, but the RMS of the velocity on an axis
// is 1.11 m/s, hardly more than the 1.07 m/s of `circle`.
#pragma once

#include "datasets/simulation/circle.h"

namespace slammot {

struct ManoeuvresOptions {
  ManoeuvresOptions() { circle.scene.volume.manoeuvres.share = 0.5; }
  CircleOptions circle;
};
Parameters parameters(ManoeuvresOptions& options);

Sequence simulate_manoeuvres(const ManoeuvresOptions& options, std::uint64_t seed);

}  // namespace slammot
