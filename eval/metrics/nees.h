// Normalised estimation error squared, NEES = e' P^-1 e, and its summary over the frames of one
// run.
//
// e and P are in one frame and one error state: [dr (W), dtheta (C, right: R = R^ Exp(dtheta))] for
// a pose. Consistent estimates have NEES ~ chi-square(dof), mean dof. A covariance that is not
// positive definite has no NEES: it is infinite and counted as a failure, never zero.
//
// Frames of one run are correlated: its interval and the interval coverage describe and decide
// nothing; tests of consistency average over runs at one frame.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "eval/metrics/pose_pairs.h"

namespace slammot {

// False where a number is not finite.
bool is_positive_definite(const Eigen::MatrixXd& covariance);

double nees(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance);

// NaN where a number of the error or of the covariance is not defined, which is no failure.
double nees_if_defined(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance);

struct NeesSummary {
  int dof = 0;
  int used = 0;       // samples, failures included
  int failures = 0;   // covariances that are not positive definite
  double mean = 0.0;  // infinite as soon as there is one failure
  double median = 0.0;
  double q95 = 0.0;    // 95% quantile of the samples
  double lower = 0.0;  // two-sided 95% interval of a single sample
  double upper = 0.0;
  double interval_coverage = 0.0;  // samples inside the interval, as a ratio
};

// Samples of which one is not defined (NaN) have no summary.
NeesSummary summarise_nees(const std::vector<double>& samples, int dof);

struct PoseNees {
  int frame = 0;
  double timestamp = 0.0;
  double pose = 0.0;      // 6
  double position = 0.0;  // 3
  double rotation = 0.0;  // 3
};

// NaN where the covariance of that part is not known.
PoseNees pose_nees(const PosePair& pair);

struct PoseConsistency {
  NeesSummary pose;
  NeesSummary position;
  NeesSummary rotation;
  std::vector<PoseNees> series;

  void forget_rotations();  // of pose and rotation nothing is known
};

// Leaves out the first pair: before the first prediction the covariance is the initial state's pin.
PoseConsistency pose_consistency(const std::vector<PosePair>& pairs);

}  // namespace slammot
