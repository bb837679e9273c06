// What the EKF knows of the scale, kept while its estimate moves.
//
// Pixels do not tell the scale of what they measure. Their Jacobians are zero along
//
//   n(x) = dx / d(log scale):
//
// positions (about any fixed point) and velocities as they are, inverse depths -rho. So an update
// learns nothing along n(x). The next one, at x + dx, learns nothing along n(x + dx): in the
// coordinates of P another direction. Together they seem to measure the scale, a little in every
// frame (as an EKF invents a heading: Huang, Mourikis & Roumeliotis 2008), and the more it is in
// doubt. With errors written as e = n(x) lambda + rest, lambda being the error of the log of the
// scale, an update only moves the estimate, and lambda and the rest keep their covariance (the
// equivariant filter's way: van Goor & Mahony 2023). In the coordinates of P that is
//
//   e := e + (n(x + dx) - n(x)) lambda,   lambda = l'e.
//
// Which scale: where no landmark is known beforehand, that of the whole map. Else that of what was
// measured in the last hundred frames, since known landmarks that left long ago say little of it.
// lambda is the mean of the errors of -log rho of these static landmarks, and of the log of the
// speed, weighted with their inverse variances w_i:
//
//   l'e = (-sum w_i drho_i / rho_i + w_v v'dv / |v|^2) / (1 + sum w_i + w_v).
//
// The 1 keeps l finite where nothing is known of the scale.
#pragma once

#include <span>

#include "filters/covariance/joint_state.h"
#include "models/landmarks/landmark_models.h"

namespace slammot {

class ScaleError {
 public:
  ScaleError(const LandmarkFunctions& landmark, bool any_known)
      : functions_(landmark), any_known_(any_known) {}

  // x := x [+] dx after an update, P in the coordinates at the new estimate.
  void correct(JointState& state, Eigen::Ref<const Eigen::VectorXd> dx);

  // w = 0 is about to be used as a measurement of these landmarks. A world of another scale has it
  // as well: where w is in metres, its errors are expressed there.
  void collapse(JointState& state, std::span<const int> tracks);

  // Before free landmarks are corrected alone: lambda, which has nothing of them, and P l.
  void prepare(const JointState& state);

  // n(x) of a landmark's (y, w).
  LandmarkVector direction(const FilterLandmark& landmark) const;

  // A free landmark was corrected alone, n(x) having been `before`. With b its rows, P[:, b] - C
  // and P[b, b] - D are its covariance; afterwards they are that in the coordinates at the new
  // estimate.
  void moved_alone(const FilterLandmark& landmark, const LandmarkVector& before,
                   Eigen::Ref<Eigen::MatrixXd> C, JointCovariance::Block& D);

 private:
  using Vector = Eigen::Map<Eigen::VectorXd>;
  static Vector vector(GrowingMatrix& x) { return {(*x).data(), (*x).rows()}; }

  Vector weigh(const JointState& state);
  Vector direction(const JointState& state, GrowingMatrix& n) const;

  bool is_of_late(int last_used, int newest) const;

  const LandmarkFunctions& functions_;
  bool any_known_;
  GrowingMatrix l_, P_l_, before_, change_;  // n x 1; kept for their memory
  double variance_ = 0.0;
};

}  // namespace slammot
