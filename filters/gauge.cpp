#include "filters/gauge.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "models/points/scale.h"

namespace slammot {

namespace {

// dp/dc of what stands at p, or of a vector p that turns with the world.
Eigen::Matrix3d turned(const Eigen::Vector3d& p) { return -hat(p); }

// dy/dc of a landmark whose direction turns by c.
Eigen::Matrix3d turned(const PointFunctions& point, const Eigen::Vector3d& y) {
  const PointRay ray = point.ray(y);
  const Matrix34d J = point.of_jacobian(ray.direction, ray.inverse_depth);
  return -J.leftCols<3>() * hat(ray.direction);
}

}  // namespace

GaugeError::Directions GaugeError::directions(const FilterLandmark& landmark) const {
  Directions N = Directions::Zero(landmark.dim(), columns());
  const auto motion = landmark.w.size();
  if (gauge_ == Gauge::kHeading) {
    N.topRows<3>() = turned(functions_.point, landmark.y);
    for (Eigen::Index k = 0; k + 3 <= motion; k += 3) {  // velocity, acceleration
      N.middleRows<3>(3 + k) = turned(Eigen::Vector3d(landmark.w.segment<3>(k)));
    }
    return N;
  }
  N.topRows<3>() = along_scale(functions_.point, landmark.y);
  if (landmark.is_free() && functions_.motion_in_metres) N.bottomRows(motion) = landmark.w;
  return N;
}

void GaugeError::fill_directions(const JointState& state, GrowingMatrix& into) const {
  into.resize(state.covariance.size(), columns());
  auto N = *into;
  N.setZero();
  const bool turns = gauge_ == Gauge::kHeading;
  const auto put = [&](int offset, const Eigen::Vector3d& p) {
    if (turns) {
      N.middleRows<3>(offset) = turned(p);
    } else {
      N.middleRows<3>(offset) = p;
    }
  };
  const auto put_rotation = [&](int offset, const Eigen::Quaterniond& R) {
    if (turns) N.middleRows<3>(offset) = R.conjugate().toRotationMatrix();
  };
  put(kPosition, state.camera.position);
  put(kVelocity, state.camera.velocity);
  put_rotation(kRotation, state.camera.orientation);
  if (state.scene && !turns) N(state.scene->block.offset, 0) = -state.scene->inverse_depth;
  for (const FilterPose& clone : state.clones) {
    put(clone.block.offset + kPosition, clone.position);
    put_rotation(clone.block.offset + kRotation, clone.orientation);
  }
  for (const auto& [frame, anchor] : state.anchors) put(anchor.block.offset, anchor.position);
  for (const auto& [track, landmark] : state.landmarks) {
    const Directions of_it = directions(landmark);
    const StateBlock w = landmark.w_block;
    N.middleRows<3>(landmark.y_block.offset) = of_it.topRows<3>();
    if (landmark.is_free()) N.middleRows(w.offset, w.dim) = of_it.bottomRows(w.dim);
  }
}

bool GaugeError::is_recently_measured(int last_used, int newest) const {
  constexpr int kFrames = 100;
  return !knows_scale_ || last_used >= newest - kFrames;
}

void GaugeError::fill_weights(const JointState& state) {
  L_.resize(state.covariance.size(), columns());
  auto L = *L_;
  L.setZero();
  if (gauge_ == Gauge::kHeading) {
    L.middleRows<3>(kRotation) = state.camera.orientation.conjugate().toRotationMatrix();
  } else {
    weigh_scale(state, L.col(0));
  }
}

void GaugeError::weigh_scale(const JointState& state, Eigen::Ref<Eigen::VectorXd> l) const {
  const JointCovariance& P = state.covariance;
  double sum = 1.0;
  int newest = 0;
  for (const auto& [track, landmark] : state.landmarks) {
    newest = std::max(newest, landmark.last_used);
  }
  for (const auto& [track, landmark] : state.landmarks) {
    if (landmark.is_free() || !is_recently_measured(landmark.last_used, newest)) continue;
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
}

// Heading: P needs no right Jacobian, since the errors are written in c. Scale: as
// JointState::correct.
void GaugeError::correct(JointState& state, Eigen::Ref<const Eigen::VectorXd> dx) {
  fill_weights(state);
  fill_directions(state, before_);
  if (gauge_ == Gauge::kHeading) {
    state.move(dx);
  } else {
    state.correct(dx);
  }
  fill_directions(state, change_);
  *change_ -= *before_;
  state.covariance.add_dependence(*L_, *change_);
}

void GaugeError::collapse(JointState& state, std::span<const int> tracks) {
  fill_weights(state);
  change_.resize(state.covariance.size(), columns());
  auto change = *change_;
  change.setZero();
  for (const int track : tracks) {
    const FilterLandmark& landmark = state.landmarks.at(track);
    const StateBlock w = landmark.w_block;
    change.middleRows(w.offset, w.dim) = -directions(landmark).bottomRows(w.dim);  // 0 at w = 0
  }
  state.covariance.add_dependence(*L_, change);
}

void GaugeError::prepare(const JointState& state) {
  fill_weights(state);
  P_L_.resize((*L_).rows(), columns());
  state.covariance.multiply(*L_, *P_L_);
  variance_ = (*L_).transpose().lazyProduct(*P_L_);
}

void GaugeError::moved_alone(const FilterLandmark& landmark, const Directions& before,
                             Eigen::Ref<Eigen::MatrixXd> C, JointCovariance::Block& D) {
  const StateBlock y = landmark.y_block, w = landmark.w_block;
  auto P_L = *P_L_;
  assert(P_L.rows() == C.rows() && landmark.is_free());  // prepare() came before
  const Directions change = directions(landmark) - before;
  Directions own(landmark.dim(), columns());  // of P L
  own << P_L.middleRows(y.offset, y.dim), P_L.middleRows(w.offset, w.dim);
  own -= C.transpose().lazyProduct(*L_);
  const LandmarkMatrix cross = change.lazyProduct(own.transpose());
  D -= cross + cross.transpose() + change.lazyProduct(variance_).lazyProduct(change.transpose());
  C -= P_L.lazyProduct(change.transpose());
  own += change.lazyProduct(variance_);
  P_L.middleRows(y.offset, y.dim) = own.topRows(y.dim);
  P_L.middleRows(w.offset, w.dim) = own.bottomRows(w.dim);
}

}  // namespace slammot
