// From an estimator's belief about a landmark to what is reported in metres.
#pragma once

#include "estimation/track_policy.h"
#include "models/landmarks/landmark_models.h"

namespace slammot {

// Joint belief of anchor (3), y (3) and, for a free landmark, w, in this order.
struct LandmarkBelief {
  Eigen::Vector3d anchor;
  Eigen::Vector3d y;
  MotionVector w;              // empty when static
  Eigen::MatrixXd covariance;  // (6 + w) x (6 + w)
};

// Position (2.4) and velocity with covariances to first order; NaN at infinity and, for the
// velocity, when the landmark is static.
LandmarkEstimate landmark_estimate(const LandmarkFunctions& model, const TrackRecord& record,
                                   const LandmarkBelief& belief);

}  // namespace slammot
