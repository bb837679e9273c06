// What the EKF knows of a direction that no measurement tells, kept while its estimate moves
// (`gauge`).
//
// Pixels say nothing along N(x) = dx/dg, of a gauge g:
//
// - `scale`: N = dx / d(log scale): positions (about any fixed point) and velocities as they are,
//   inverse depths -rho.
// - `heading`: N = dx / dc of a turn c of the world (3 columns): what stands at p moves by
//   c x p = -hat(p) c.
//
// So an update learns nothing along N(x). The next one, at x + dx, learns nothing along N(x + dx):
// in the coordinates of P another direction. Together they seem to measure the gauge, a little in
// every frame (as an EKF invents a heading: Huang, Mourikis & Roumeliotis 2008), and the more it is
// in doubt. With errors written as e = N(x) lambda + rest, lambda being the error of the gauge, an
// update only moves the estimate, and lambda and the rest keep their covariance (the equivariant
// filter's way: van Goor & Mahony 2023; for the heading the right-invariant error: Barrau &
// Bonnabel 2015). In the coordinates of P that is
//
//   e := e + (N(x + dx) - N(x)) lambda,   lambda = L'e.
//
// Which heading: the camera's, c = R dtheta. Which scale: where nothing tells the scale,
// that of the whole map. Else that of what was measured in the last hundred frames, since known
// landmarks that left long ago say little of it. lambda is the mean of the errors of -log rho of
// these static landmarks, and of the log of the speed, weighted with their inverse variances w_i:
//
//   L'e = (-sum w_i drho_i / rho_i + w_v v'dv / |v|^2) / (1 + sum w_i + w_v).
//
// The 1 keeps L finite where nothing is known of the scale.
#pragma once

#include <span>

#include "estimation/options.h"
#include "filters/covariance/joint_state.h"
#include "models/landmarks/landmark_models.h"

namespace slammot {

class GaugeError {
 public:
  // N of a landmark's (y, w).
  using Directions = BoundedMatrix<Eigen::Dynamic, Eigen::Dynamic, kMaxLandmark, 3>;

  // `gauge`: not kNone.
  GaugeError(Gauge gauge, const LandmarkFunctions& landmark, bool knows_scale)
      : gauge_(gauge), functions_(landmark), knows_scale_(knows_scale) {}

  // x := x [+] dx after an update, P in the coordinates at the new estimate.
  void correct(JointState& state, Eigen::Ref<const Eigen::VectorXd> dx);

  // w = 0 is about to be used as a measurement of these landmarks. A world of another scale or
  // heading has it as well: the errors of w are expressed there.
  void collapse(JointState& state, std::span<const int> tracks);

  // Before landmarks are corrected alone: lambda, which has nothing of them, and P L.
  void prepare(const JointState& state);

  Directions directions(const FilterLandmark& landmark) const;

  // A free landmark was corrected alone, N having been `before`. With b its rows, P[:, b] - C and
  // P[b, b] - D are its covariance; afterwards they are that in the coordinates at the new
  // estimate.
  void moved_alone(const FilterLandmark& landmark, const Directions& before,
                   Eigen::Ref<Eigen::MatrixXd> C, JointCovariance::Block& D);

 private:
  int columns() const { return gauge_ == Gauge::kHeading ? 3 : 1; }
  void fill_directions(const JointState& state, GrowingMatrix& N) const;
  void fill_weights(const JointState& state);
  void weigh_scale(const JointState& state, Eigen::Ref<Eigen::VectorXd> l) const;
  bool is_recently_measured(int last_used, int newest) const;

  Gauge gauge_;
  const LandmarkFunctions& functions_;
  bool knows_scale_;
  GrowingMatrix L_, P_L_, before_, change_;  // n x columns(); kept for their memory
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 3, 3> variance_;
};

}  // namespace slammot
