// Errors and NEES of the landmarks' latest estimates, against where they truly were in that frame.
//
// Known landmarks are left out: they were given their true position, not estimated. Only what has a
// covariance has a NEES; the velocity of a landmark held static has none.
#pragma once

#include <vector>

#include "datasets/sequence/sequence.h"
#include "eval/metrics/nees.h"
#include "eval/result/run_result.h"

namespace slammot {

struct ErrorSummary {
  int used = 0;
  double rmse = 0.0;
  double median = 0.0;
  double q95 = 0.0;
};

struct LandmarkErrors {
  ErrorSummary static_position;  // [m], truly static landmarks
  ErrorSummary moving_position;  // [m]
  ErrorSummary moving_velocity;  // [m/s]
};

struct LandmarkConsistency {
  NeesSummary position;
  NeesSummary velocity;
};

struct LandmarkMetrics {
  LandmarkErrors errors;
  LandmarkConsistency consistency;
};

LandmarkMetrics landmark_metrics(const Sequence& sequence,
                                 const std::vector<LandmarkRecord>& landmarks);

}  // namespace slammot
