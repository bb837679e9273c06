// How a moving point sways about its straight line: it brakes and speeds up along its course, and
// turns to either side of it.
//
// The acceleration is a sum of sinusoids, two along the course and two across it:
//   a(t) = sum_k A_k sin(w_k t + phi_k).
// Velocity and position are its integrals without a drift, in closed form, so that all three are
// exact and smooth, and the mean velocity stays that of the line.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "datasets/simulation/parameters/parameters.h"
#include "datasets/simulation/random/random_stream.h"

namespace slammot {

struct Sway {
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // A, amplitude in W [m/s^2]
  double rate = 1.0;                                       // w [rad/s]
  double phase = 0.0;                                      // phi [rad]
};

// What is added to the motion along the line, in W.
struct Manoeuvre {
  std::array<Sway, 4> sways;

  Eigen::Vector3d offset(double time) const;        // of the position [m]
  Eigen::Vector3d velocity(double time) const;      // [m/s]
  Eigen::Vector3d acceleration(double time) const;  // [m/s^2]
  double reach() const;                             // bound of |offset| [m]
};

struct ManoeuvreOptions {
  double share = 0.0;    // of the moving points that never stop
  double lateral = 2.0;  // largest acceleration across the course, horizontal [m/s^2]
  double braking = 1.0;  // largest along it, braking or speeding up [m/s^2]
  double period = 4.0;   // mean of the sinusoids' [s]
};
Parameters parameters(ManoeuvreOptions& options);

// The period of a sinusoid is uniform within this part of the mean, to either side.
inline constexpr double kPeriodSpread = 0.25;

// The largest change of speed along the course by braking [m/s].
double largest_slowing(const ManoeuvreOptions& options);

// Of one object on the course of `velocity`; none for one that keeps its velocity.
std::optional<Manoeuvre> draw_manoeuvre(const ManoeuvreOptions& options,
                                        const Eigen::Vector3d& velocity, RandomStream& random);

}  // namespace slammot
