// How much the moving points of a volume accelerate, computed from the options: what a prior of
// their motion can state without looking at a sequence.
#pragma once

#include "datasets/simulation/scene/volume.h"

namespace slammot {

// On a horizontal axis of W, over all moving points that never stop.
struct MoverSigmas {
  double acceleration = 0.0;  // [m/s^2]
  double jerk = 0.0;          // [m/s^3]
};

// Root mean square of the true acceleration and of its derivative.
//
// A sinusoid of amplitude A has the mean square A^2 / 2, and its derivative w^2 A^2 / 2. Two of
// amplitude b / 2 along the course and two of l / 2 across it give b^2 / 4 and l^2 / 4. Courses are
// uniform in azimuth, so that a horizontal axis has half of either; of a course that climbs by c,
// uniform up to C, only the part E cos^2 c = 1/2 + sin(2C) / (4C) is horizontal. Hence, with the
// share p of movers that manoeuvre,
//   E a^2 = p / 8 (b^2 E cos^2 c + l^2),   E j^2 = E w^2 E a^2,
// where E w^2 = (2 pi / period)^2 / (1 - spread^2) for periods uniform in period (1 -+ spread).
MoverSigmas rms_of_movers(const VolumeOptions& options);

}  // namespace slammot
