// Scenario `move_stop_move`: the scene and camera of `circle` with objects that stop for a while
// and move again, objects that are parked and leave, and objects that keep their velocity.
//
// An object that ever moves has the class `moving`, and while it stands a velocity of zero. The
// acceleration stated of objects covers their stops and starts.
#pragma once

#include "datasets/simulation/circle.h"

namespace slammot {

struct MoveStopMoveOptions {
  MoveStopMoveOptions() {
    circle.scene.volume.stops.stopping_fraction = 0.5;
    circle.scene.volume.stops.parked_fraction = 0.25;
  }
  CircleOptions circle;
};
Parameters parameters(MoveStopMoveOptions& options);

Sequence simulate_move_stop_move(const MoveStopMoveOptions& options, std::uint64_t seed);

}  // namespace slammot
