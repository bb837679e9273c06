#include "datasets/simulation/move_stop_move.h"

#include <stdexcept>

namespace slammot {

Parameters parameters(MoveStopMoveOptions& o) {
  return joined(parameters(o.circle.scene.volume.stops), parameters(o.circle));
}

Sequence simulate_move_stop_move(const MoveStopMoveOptions& options, std::uint64_t seed) {
  const StopOptions& stops = options.circle.scene.volume.stops;
  if (stops.stopping_fraction + stops.parked_fraction > 1.0) {
    throw std::invalid_argument("stopping, parked: together at most 1");
  }
  return simulate_circle(options.circle, seed);
}

}  // namespace slammot
