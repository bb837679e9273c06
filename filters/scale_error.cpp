#include "filters/scale_error.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace slammot {

LandmarkVector ScaleError::direction(const FilterLandmark& landmark) const {
  const PointRay ray = functions_.point.ray(landmark.y);
  const Matrix34d J = functions_.point.of_jacobian(ray.direction, ray.inverse_depth);
  LandmarkVector n = LandmarkVector::Zero(landmark.dim());
  n.head<3>() = -ray.inverse_depth * J.col(3);
  if (landmark.is_free() && functions_.motion_in_metres) n.tail(landmark.w.size()) = landmark.w;
  return n;
}

ScaleError::Vector ScaleError::direction(const JointState& state, GrowingMatrix& into) const {
  into.resize(state.covariance.size(), 1);
  Vector n = vector(into);
  n.setZero();
  n.segment<3>(kPosition) = state.camera.position;
  n.segment<3>(kVelocity) = state.camera.velocity;
  if (state.scene) n(state.scene->block.offset) = -state.scene->inverse_depth;
  for (const FilterPose& clone : state.clones) n.segment<3>(clone.block.offset) = clone.position;
  for (const auto& [frame, anchor] : state.anchors) {
    n.segment<3>(anchor.block.offset) = anchor.position;
  }
  for (const auto& [track, landmark] : state.landmarks) {
    const LandmarkVector of_it = direction(landmark);
    const StateBlock w = landmark.w_block;
    n.segment<3>(landmark.y_block.offset) = of_it.head<3>();
    if (landmark.is_free()) n.segment(w.offset, w.dim) = of_it.tail(w.dim);
  }
  return n;
}

bool ScaleError::is_of_late(int last_used, int newest) const {
  constexpr int kFrames = 100;
  return !any_known_ || last_used >= newest - kFrames;
}

ScaleError::Vector ScaleError::weigh(const JointState& state) {
  const JointCovariance& P = state.covariance;
  l_.resize(P.size(), 1);
  Vector l = vector(l_);
  l.setZero();
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
    const double rho = ray.inverse_depth, variance = J * P.block(y, y) * J.transpose();
    if (!(variance > 0.0) || !std::isfinite(rho * rho / variance)) continue;
    l.segment<3>(y.offset) = -rho / variance * J.transpose();
    sum += rho * rho / variance;
  }
  constexpr StateBlock kV{kVelocity, 3};
  const Eigen::Vector3d v = state.camera.velocity;
  const double v2 = v.squaredNorm(), v_variance = v.dot(P.block(kV, kV) * v);
  if (v_variance > 0.0 && std::isfinite(v2 * v2 / v_variance)) {
    l.segment<3>(kVelocity) = v2 / v_variance * v;
    sum += v2 * v2 / v_variance;
  }
  l /= sum;
  return l;
}

void ScaleError::correct(JointState& state, Eigen::Ref<const Eigen::VectorXd> dx) {
  const Vector l = weigh(state), before = direction(state, before_);
  state.correct(dx);
  Vector change = direction(state, change_);
  change -= before;
  state.covariance.add_dependence(l, change);
}

void ScaleError::collapse(JointState& state, std::span<const int> tracks) {
  if (!functions_.motion_in_metres) return;
  const Vector l = weigh(state);
  change_.resize(state.covariance.size(), 1);
  Vector change = vector(change_);
  change.setZero();
  for (const int track : tracks) {
    const FilterLandmark& landmark = state.landmarks.at(track);
    change.segment(landmark.w_block.offset, landmark.w_block.dim) = -landmark.w;
  }
  state.covariance.add_dependence(l, change);
}

void ScaleError::prepare(const JointState& state) {
  const Vector l = weigh(state);
  P_l_.resize(l.size(), 1);
  state.covariance.multiply(l, vector(P_l_));
  variance_ = l.dot(vector(P_l_));
}

void ScaleError::moved_alone(const FilterLandmark& landmark, const LandmarkVector& before,
                             Eigen::Ref<Eigen::MatrixXd> C, JointCovariance::Block& D) {
  const StateBlock y = landmark.y_block, w = landmark.w_block;
  Vector P_l = vector(P_l_);
  assert(P_l.size() == C.rows() && landmark.is_free());  // prepare() came before
  const LandmarkVector change = direction(landmark) - before;
  LandmarkVector own(landmark.dim());  // of P l
  own << P_l.segment(y.offset, y.dim), P_l.segment(w.offset, w.dim);
  own.noalias() -= C.transpose() * vector(l_);
  const LandmarkMatrix cross = change * own.transpose();
  D -= cross + cross.transpose() + variance_ * change * change.transpose();
  C.noalias() -= P_l * change.transpose();
  own += variance_ * change;
  P_l.segment(y.offset, y.dim) = own.head(y.dim);
  P_l.segment(w.offset, w.dim) = own.tail(w.dim);
}

}  // namespace slammot
