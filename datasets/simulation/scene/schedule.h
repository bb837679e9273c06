// When an object moves along its line: it stands until `start`, and from then on goes through
// cycles of speeding up, moving, braking and standing. Speed changes linearly, so that velocity is
// continuous; while it stands, velocity is exactly zero and position exactly the same.
#pragma once

#include <optional>

#include "datasets/simulation/parameters/parameters.h"
#include "datasets/simulation/random/random_stream.h"

namespace slammot {

struct Schedule {
  double start = 0.0;     // [s]
  double ramp = 0.0;      // from standing to full speed, and back [s]
  double moving = 0.0;    // at full speed, in a cycle [s]
  double standing = 0.0;  // likewise [s]

  double pace(double time) const;       // part of full speed: 0 to 1
  double travelled(double time) const;  // the integral of it: seconds of full speed

 private:
  double cycle() const { return 2.0 * ramp + moving + standing; }
};

// Which objects stop, and for how long. The others keep their velocity for ever.
struct StopOptions {
  double stopping_fraction = 0.0;  // go through cycles, wherever in theirs the run begins
  double parked_fraction = 0.0;    // stand until a random time of the run, then move for ever
  double move_time = 2.0;          // at full speed [s]
  double stop_time = 2.0;          // at rest [s]
  double ramp_time = 0.5;          // of braking, and of speeding up [s]
};
Parameters parameters(StopOptions& options);

// Of one object in a run of `duration` [s]; none for one that never stops.
std::optional<Schedule> draw_schedule(const StopOptions& options, double duration,
                                      RandomStream& random);

}  // namespace slammot
