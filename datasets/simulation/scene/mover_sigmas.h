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

// The white noise per step of `dt` that explains how far velocity and acceleration stray over every
// horizon, as prior_of() measures it: of a sinusoid x with rate w, after tau = n dt,
//   RMS(x(t + tau) - x(t))^2 / (n dt^2) = 2 RMS(x)^2 (1 - cos w tau) / (tau dt),
// which is largest at w tau = 2.3311: 1.4492 RMS(x')^2 / (w dt). So it is the RMS of the derivative
// times sqrt(1.4492 / (w dt)), here with w of the mean period; for steps much shorter than that.
//
// An honest noise, but no useful one: it is stated of every landmark whose motion is unknown, and
// with the 2.1 m/s^2 of the scenario `manoeuvres` hardly any static one is ever found static. With
// the RMS, 0.56 m/s^2, they are, and the velocities of movers are overconfident.
MoverSigmas white_noise_of_movers(const VolumeOptions& options, double dt);

}  // namespace slammot
