#include "datasets/simulation/scene/schedule.h"

#include <algorithm>
#include <cmath>

namespace slammot {

double Schedule::pace(double time) const {
  if (time <= start) return 0.0;
  const double w = std::fmod(time - start, cycle());
  if (w < ramp) return w / ramp;
  const double braking = w - ramp - moving;
  if (braking < 0.0) return 1.0;
  return braking < ramp ? 1.0 - braking / ramp : 0.0;
}

double Schedule::travelled(double time) const {
  if (time <= start) return 0.0;
  const double cycles = std::floor((time - start) / cycle());
  const double w = time - start - cycles * cycle();
  const double speeding = std::min(w, ramp);
  const double cruising = std::clamp(w - ramp, 0.0, moving);
  const double braking = std::clamp(w - ramp - moving, 0.0, ramp);
  const double ramps = ramp > 0.0 ? (speeding * speeding - braking * braking) / (2.0 * ramp) : 0.0;
  return cycles * (ramp + moving) + ramps + cruising + braking;
}

Parameters parameters(StopOptions& o) {
  return {
      {"stopping", "fraction of moving points that stop and go", &o.stopping_fraction, 0},
      {"parked", "fraction of moving points that are parked at first", &o.parked_fraction, 0},
      {"move_time", "at full speed between two stops [s]", &o.move_time, kAbove0},
      {"stop_time", "of a stop [s]", &o.stop_time, kAbove0},
      {"ramp_time", "of braking, and of speeding up [s]", &o.ramp_time, 0},
  };
}

std::optional<Schedule> draw_schedule(const StopOptions& options, double duration,
                                      RandomStream& random) {
  constexpr double kForEver = 1e9;  // [s]
  const double kind = random.uniform(0.0, 1.0);
  const double when = random.uniform(0.0, 1.0);
  Schedule schedule{0.0, options.ramp_time, options.move_time, options.stop_time};
  if (kind < options.stopping_fraction) {
    const double cycle = 2.0 * schedule.ramp + schedule.moving + schedule.standing;
    schedule.start = -when * cycle;
    return schedule;
  }
  if (kind >= options.stopping_fraction + options.parked_fraction) return std::nullopt;
  schedule.start = when * duration;
  schedule.moving = kForEver;
  return schedule;
}

}  // namespace slammot
