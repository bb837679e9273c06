#include "estimation/landmark_estimate.h"

namespace slammot {

LandmarkEstimate landmark_estimate(const LandmarkFunctions& model, const TrackRecord& record,
                                   const LandmarkBelief& belief) {
  LandmarkEstimate result = report(record);
  if (model.point.inverse_depth(belief.y) == 0.0) return result;
  Eigen::Matrix<double, 3, 6> J_position;
  J_position << Eigen::Matrix3d::Identity(), position_jacobian(model.point, belief.y);
  result.position = position_world(model.point, belief.anchor, belief.y);
  result.position_covariance =
      J_position * belief.covariance.topLeftCorner<6, 6>() * J_position.transpose();
  if (belief.w.size() == 0) return result;
  const LandmarkVector x = landmark_state(belief.y, belief.w);
  const VelocityJacobian J_velocity = model.velocity_jacobian(x);
  result.velocity = model.velocity(x);
  result.velocity_covariance =
      J_velocity * belief.covariance.bottomRightCorner(x.size(), x.size()) * J_velocity.transpose();
  return result;
}

}  // namespace slammot
