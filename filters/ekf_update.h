// The measurement side of the EKF: innovations, the chi-square gate, and one update for all
// measurements of a frame. Knows nothing of how landmarks move: all models observe alike.
#pragma once

#include "slammot/filters/linearisation.h"
#include "slammot/models/gate.h"
#include "slammot/models/observation.h"

namespace slammot {

// A measurement of a landmark that is in the state.
struct Match {
  int track = 0;
  Eigen::Vector2d pixel;
};

// The measurements of a frame linearised at the state: innovation nu = z - h(x), H as its thin
// product P H' (n x 2m), S = H P H' + R. Two rows (columns) a match, in the order of the matches.
struct Innovation {
  std::vector<Match> matches;
  std::vector<ObservedPixel> predicted;
  Eigen::VectorXd nu;
  Eigen::MatrixXd P_Ht;

  int rows() const { return 2 * static_cast<int>(matches.size()); }
};

// Linearises; matches whose landmark is not expected in view are left out (observation.h).
Innovation innovation(const JointState& state, const Linearisation& linearisation,
                      const Camera& camera, const std::vector<Match>& matches);

// H x for a vector or matrix x with the state's rows; `x` may be P H', which gives H P H'.
Eigen::MatrixXd apply_H(const JointState& state, const Innovation& innovation,
                        const Eigen::MatrixXd& x);

struct Gate {
  Innovation accepted;
  std::vector<int> rejected;  // tracks
  std::vector<double> nis;    // of every match of the innovation
  double nis_sum = 0.0;       // over the accepted
};

// Each match on its own.
Gate gate(const JointState& state, const Innovation& innovation, const PixelGate& test);

// x and P after the measurements. `iterations` Gauss-Newton steps on the same prior (1: EKF).
// Throws Diverged when S is not positive definite or the correction not finite.
void update(JointState& state, const Linearisation& linearisation, const Camera& camera,
            const Innovation& first, double pixel_variance, int iterations);

// A measurement that moves only its own landmark, the rest of the state being considered but not
// corrected (Schmidt's gain): what a delayed initialisation would know of it.
void update_alone(JointState& state, const Linearisation& linearisation, const Camera& camera,
                  const Match& match, double pixel_variance);

}  // namespace slammot
