// From an estimator's belief about a landmark to what is reported in metres.
#pragma once

#include "slammot/models/landmark.h"
#include "slammot/models/track_policy.h"

namespace slammot {

// Joint belief of anchor (3), y (3) and, for a free landmark, w (3), in this order.
struct LandmarkBelief {
  Eigen::Vector3d anchor;
  Eigen::Vector3d y;
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  Eigen::MatrixXd covariance;  // 6x6 or 9x9
};

// Position (2.4) and velocity with covariances to first order; NaN at infinity and, for the
// velocity, when the landmark is static.
template <LandmarkModel M>
LandmarkEstimate landmark_estimate(const TrackRecord& record, const LandmarkBelief& belief) {
  LandmarkEstimate result = report(record);
  if (belief.y.z() == 0.0) return result;
  Eigen::Matrix<double, 3, 6> J_position;
  J_position << Eigen::Matrix3d::Identity(), position_jacobian(belief.y);
  result.position = position_world(belief.anchor, belief.y);
  result.position_covariance =
      J_position * belief.covariance.topLeftCorner<6, 6>() * J_position.transpose();
  if (belief.covariance.rows() == 9) {
    const Vector6d x = (Vector6d() << belief.y, belief.w).finished();
    const Matrix36d J_velocity = M::velocity_jacobian(x);
    result.velocity = M::velocity(x);
    result.velocity_covariance =
        J_velocity * belief.covariance.bottomRightCorner<6, 6>() * J_velocity.transpose();
  }
  return result;
}

}  // namespace slammot
