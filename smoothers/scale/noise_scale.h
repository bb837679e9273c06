// What the camera's noise says of the scale, and leaving it out.
//
// The noise of a step is stated in metres: the linear part of r = L^-1 (x1 [-] f(x0)) grows with
// the scale of the world. A smoother takes the most probable path, and |r|^2 is least for a small
// world. A filter has no such preference: it integrates over all paths that the images allow, whose
// volume grows with the scale. Known landmarks or depths hold a smoother's world against it. Where
// only the first velocity tells the scale nothing does, and the noise is taken in units of the
// speed: as sigma_a |v| / |v^|, where v^ is v at the estimate. That leaves r as it is, and of its
// Jacobian takes what lies along the scale,
//
//   J_v1 := J_v1 - r v1' / (|v1|^2 + e^2),   of the linear part of r,
//
// e being a tenth of the sigma of v1 in a step, which keeps it finite at rest. (With all of it, or
// with the posterior sigma of the speed, a share e^2/|v1|^2 of r is left in every frame, and a slow
// camera's world shrinks.)
//
// That is the Jacobian of a cost in which |v^| is a constant, the same in a world of any size:
//
//   r_v u(v^) / u(v1),   u(v) = (|v|^2 + e^2)^(1/2).
//
// Ceres (the batch, `window.solver=ceres`) minimises it, takes v^ = v1 there, and so on until v1
// stays; our own solver takes v^ in every step. A camera that sets off from rest would have its
// noise for nothing. So in one solution the ratio is 0.9 at least and 1.1 at most, and v^ follows
// to the minimum nearby; and our own solver judges steps by the cost in metres.
//
// Motions of landmarks in metres are in units as well, of their distance, and by a cost of their
// own (smoothers/graph/chain_step.h).
#pragma once

#include <algorithm>
#include <cmath>

#include "estimation/estimator.h"
#include "models/camera_state.h"

namespace slammot {

// False where no landmark is known and the spread of depths follows a mean that is estimated.
inline bool noise_tells_scale(const Setup& setup) {
  return setup.knows_scale() || !setup.prior.spread_follows_mean;
}

// e [m/s]; `weight` is L^-1.
inline double unknown_speed(const Matrix12d& weight) {
  constexpr double kOfAStep = 0.1;
  return kOfAStep / weight(kVelocity, kVelocity);
}

inline constexpr double kLeastOfUnits = 0.9, kMostOfUnits = 1.1;

// u(v) [m/s], `sigma` being e.
inline double unit_of_speed(const Eigen::Vector3d& velocity, double sigma) {
  return std::sqrt(velocity.squaredNorm() + sigma * sigma);
}

// u(v^) / u(v1), within its limits.
inline double ratio_of_units(double unit, const Eigen::Vector3d& velocity, double sigma) {
  return std::clamp(unit / unit_of_speed(velocity, sigma), kLeastOfUnits, kMostOfUnits);
}

// Of the linear part: rows of r or of its Jacobians times `factor`.
template <typename Rows>
void scale_linear_part(double factor, Rows& rows) {
  for (const int part : {kPosition, kVelocity}) rows.template middleRows<3>(part) *= factor;
}

// `velocity` is v1, `sigma` e, and `J_to` the 12 x 12 Jacobian of r with respect to x1.
inline void leave_out_scale(const Eigen::Vector3d& velocity, double sigma, const Vector12d& r,
                            Matrix12d& J_to) {
  const Eigen::RowVector3d of_scale =
      velocity.transpose() / (velocity.squaredNorm() + sigma * sigma);
  for (const int part : {kPosition, kVelocity}) {
    J_to.block<3, 3>(part, kVelocity) -= r.segment<3>(part) * of_scale;
  }
}

}  // namespace slammot
