#include "filters/scale_error.h"

#include <algorithm>

namespace slammot {

LandmarkVector ScaleError::direction(const FilterLandmark& landmark) const {
  const PointRay ray = functions_.point.ray(landmark.y);
  LandmarkVector n(landmark.dim());
  n.head<3>() =
      -ray.inverse_depth * functions_.point.of_jacobian(ray.direction, ray.inverse_depth).col(3);
  if (landmark.is_free()) n.tail(landmark.w.size()) = landmark.w * functions_.motion_in_metres;
  return n;
}

void ScaleError::direction(const JointState& state, Eigen::VectorXd& n) const {
  n.setZero(state.covariance.size());
  n.segment<3>(kPosition) = state.camera.position;
  n.segment<3>(kVelocity) = state.camera.velocity;
  if (state.scene) n(state.scene->block.offset) = -state.scene->inverse_depth;
  for (const FilterPose& clone : state.clones) n.segment<3>(clone.block.offset) = clone.position;
  for (const auto& [frame, anchor] : state.anchors) {
    n.segment<3>(anchor.block.offset) = anchor.position;
  }
  for (const auto& [track, landmark] : state.landmarks) {
    const LandmarkVector of_it = direction(landmark);
    n.segment<3>(landmark.y_block.offset) = of_it.head<3>();
    if (!landmark.is_free()) continue;
    n.segment(landmark.w_block.offset, landmark.w_block.dim) = of_it.tail(landmark.w_block.dim);
  }
}

bool ScaleError::is_of_late(int last_used, int newest) const {
  constexpr int kFrames = 100;
  return !any_known_ || last_used >= newest - kFrames;
}

void ScaleError::weigh(const JointState& state) {
  const JointCovariance& P = state.covariance;
  l_.setZero(P.size());
  double sum = 1.0;
  int newest = 0;
  for (const auto& [track, landmark] : state.landmarks) {
    newest = std::max(newest, landmark.last_used);
  }
  for (const auto& [track, landmark] : state.landmarks) {
    if (landmark.is_free() || !is_of_late(landmark.last_used, newest)) continue;
    const StateBlock y = landmark.y_block;
    const PointRay ray = functions_.point.ray(landmark.y);
    const auto& J = ray.J_inverse_depth;
    const double variance = J * P.block(y, y) * J.transpose();
    if (!(variance > 0.0)) continue;
    l_.segment<3>(y.offset) = -ray.inverse_depth / variance * J.transpose();
    sum += ray.inverse_depth * ray.inverse_depth / variance;
  }
  constexpr StateBlock kV{kVelocity, 3};
  const Eigen::Vector3d v = state.camera.velocity;
  const double v2 = v.squaredNorm(), vPv = v.dot(P.block(kV, kV) * v);
  if (vPv > 0.0) {
    l_.segment<3>(kVelocity) = v2 / vPv * v;
    sum += v2 * v2 / vPv;
  }
  l_ /= sum;
}

void ScaleError::correct(JointState& state, Eigen::Ref<const Eigen::VectorXd> dx) {
  weigh(state);
  direction(state, before_);
  state.correct(dx);
  direction(state, change_);
  change_ -= before_;
  state.covariance.add_dependence(l_, change_);
}

void ScaleError::prepare(const JointState& state) {
  weigh(state);
  P_l_.resize(l_.size());
  state.covariance.multiply(l_, P_l_);
  variance_ = l_.dot(P_l_);
}

void ScaleError::moved_alone(const FilterLandmark& landmark, const LandmarkVector& before,
                             Eigen::Ref<Eigen::MatrixXd> C, JointCovariance::Block& D) {
  const StateBlock y = landmark.y_block, w = landmark.w_block;
  const LandmarkVector change = direction(landmark) - before;
  LandmarkVector own(landmark.dim());  // of P l
  own << P_l_.segment(y.offset, y.dim), P_l_.segment(w.offset, w.dim);
  own -= C.transpose() * l_;
  const LandmarkMatrix cross = change * own.transpose();
  D -= cross + cross.transpose() + variance_ * change * change.transpose();
  C.noalias() -= P_l_ * change.transpose();
  own += variance_ * change;
  P_l_.segment(y.offset, y.dim) = own.head(y.dim);
  P_l_.segment(w.offset, w.dim) = own.tail(w.dim);
}

}  // namespace slammot
