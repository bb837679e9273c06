// What the maker of a simulated sequence states about it: honest by default, every number settable.
#pragma once

#include "datasets/sequence/sequence.h"
#include "datasets/simulation/parameters/parameters.h"

namespace slammot {

struct StatementOptions {
  double initial_velocity_sigma = 0.1;          // [m/s]
  double initial_angular_velocity_sigma = 0.1;  // [rad/s]
  double max_speed = 2.0;                       // [m/s]
  std::optional<double> object_acceleration;    // [m/s^2]
  std::optional<double> acceleration;           // [m/s^2]
  std::optional<double> angular_acceleration;   // [rad/s^2]
  std::optional<double> inverse_depth;          // [1/m]
  std::optional<double> inverse_depth_sigma;    // [1/m]
  // Odds of rest from outside (priors.csv): so many are right, and that is what they say; 0: none.
  double odds_right = 0.0;
};
Parameters parameters(StatementOptions& options);

// The smallest white acceleration that explains how far the true velocity strays, on every axis and
// over every horizon up to a quarter of the sequence: max RMS(v(t + n dt) - v(t)) / (dt sqrt(n)),
// and the same of the angular velocity. The RMS of the acceleration itself would be too small by
// the square root of its correlation time in steps: a camera that speeds up does so for many
// frames.
StatedMotion motion_of(const Sequence& sequence);

// What is stated of moving points that keep their velocity [m/s^2].
inline constexpr double kLeastObjectAcceleration = 0.1;

// Mean and sigma of 1/distance at first sight, over the landmarks first seen after frame 0 and not
// known beforehand. The sigma is the standard deviation, or more if that is what it takes for the
// Gaussian's 99% interval to hold 99% of them: depths have a tail towards the camera. And the
// acceleration of its moving points, as motion_of(), but no less than kLeastObjectAcceleration.
LandmarkPrior prior_of(const Sequence& sequence);

// Fills `initial` (the true pose; velocities with errors drawn from their sigmas), `motion` and
// `prior`, which is that of a scene unless overridden, and odds from outside. Wants the truth to be
// there. Throws std::invalid_argument for a share above 1.
void state(const StatementOptions& options, const LandmarkPrior& scene, std::uint64_t seed,
           Sequence& sequence);

}  // namespace slammot
