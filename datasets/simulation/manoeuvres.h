// Scenario `manoeuvres`: the scene and camera of `circle` with movers half of which turn and brake
// all the time, while the other half keep their velocity.
//
// Nobody stands still: a velocity of zero means a standing object, which is what `move_stop_move`
// is about. The acceleration stated of objects covers the manoeuvres.
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
