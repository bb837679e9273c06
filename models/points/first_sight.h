// What the frame in which a landmark is initialised says of it: its pixel in camera 0, a depth that
// something else has measured, and its pixels in the other cameras of a rig.
//
// In the frame of camera 0 all of this is about three numbers u = (pixel, rho) and not about the
// pose, so that with the prior N(rho0, sigma_rho^2) their most probable values and covariance,
//
//   min |(pixel - z_0) / sigma_0|^2 + ((rho - rho0) / sigma_rho)^2 + sum_c |(h_c(u) - z_c) /
//   sigma_c|^2,
//
// are those of the landmark whatever the camera's pose is, and initialise() (initialisation.h)
// carries them into y. A filter takes the covariance; a smoother states the same as factors.
#pragma once

#include <span>
#include <vector>

#include "models/measurement.h"
#include "models/rig.h"

namespace slammot {

// N(rho0, sigma^2) of an inverse depth [1/m].
struct InverseDepthPrior {
  double inverse_depth = 0.0, sigma = 0.0;
};

struct FirstSight {
  Observation z;                    // of camera 0
  std::vector<Observation> others;  // of the other cameras: those that agree
  InverseDepthPrior prior;
  // The prior is of this landmark alone; no mean is shared with others.
  bool has_own_depth = false;
  // Where there are others: the most probable u, and its covariance [px, px, 1/m].
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double inverse_depth = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  bool is_of_one_camera() const { return others.empty(); }
};

// Of a landmark of which nothing but its pixel says anything.
inline FirstSight first_pixel(const Observation& z, const LandmarkPrior& prior) {
  FirstSight seen;
  seen.z = z;
  seen.prior = {prior.inverse_depth, prior.inverse_depth_sigma};
  seen.pixel = z.pixel;
  return seen;
}

// The prior of rho that a measured depth is: along the ray of `z.pixel`, to first order. Nothing
// when the lens has no ray for the pixel.
std::optional<InverseDepthPrior> prior_of_depth(const Camera& camera, const Observation& z);

// `z` of camera 0, `others` of the same track. A pixel of another camera that does not agree with z
// and the prior (their sum of squares is above `threshold`), or gives no minimum, is left out.
FirstSight first_sight(const Rig& rig, double pixel_sigma, const Observation& z,
                       std::span<const Observation> others, const InverseDepthPrior& prior,
                       double threshold);

}  // namespace slammot
