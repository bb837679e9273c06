#include "filters/linearisation.h"

#include <stdexcept>

#include "estimation/depth_prior.h"
#include "models/landmarks/true_state.h"
#include "models/points/observation.h"

namespace slammot {

Linearisation::Linearisation(const EkfOptions& options, const LandmarkFunctions& landmark,
                             std::shared_ptr<const Truth> truth, bool any_known)
    : kind_(options.linearisation),
      second_order_(options.second_order),
      functions_(landmark),
      truth_(std::move(truth)) {
  if (kind_ == Kind::kIdeal && !truth_) {
    throw std::invalid_argument("linearisation ideal needs the exact truth of a simulation");
  }
  if (options.equivariant_scale && kind_ == Kind::kStandard && options.iterations == 1) {
    scale_.emplace(landmark, any_known);
  }
}

CameraState Linearisation::camera(const JointState& state) const {
  return at_estimate() || !camera_ ? state.camera : *camera_;
}

Eigen::Vector3d Linearisation::anchor(const JointState& state, int frame) const {
  return at_estimate() ? state.anchors.at(frame).position : anchors_.at(frame);
}

LandmarkVector Linearisation::landmark(const JointState& state, int track) const {
  return at_estimate() ? state.landmarks.at(track).x() : landmarks_.at(track);
}

void Linearisation::predicted(const JointState& state, int frame, double dt) {
  if (at_estimate()) return;
  forget_what_left(state);
  camera_ = kind_ == Kind::kFej ? state.camera : true_camera(*truth_, frame);
  for (const auto& [track, landmark] : state.landmarks) {
    if (kind_ == Kind::kFej) {
      predicted_first_estimate(state, track);
    } else if (landmark.is_free()) {
      LandmarkVector& x = landmarks_.at(track);
      const auto truth =
          true_state(*truth_, functions_, track, frame, anchors_.at(landmark.anchor));
      x = truth ? *truth : functions_.predict(x, dt);  // out of view it has no truth
    }
  }
}

void Linearisation::predicted_first_estimate(const JointState& state, int track) {
  constexpr double kKnownDepth = 0.1;  // sigma_rho / rho
  const FilterLandmark& landmark = state.landmarks.at(track);
  if (landmark.is_free()) settled_.erase(track);  // its label was taken back
  if (settled_.contains(track)) return;
  landmarks_[track] = landmark.is_free() ? landmark.x() : at_rest(landmark.y);
  const SeenDepth depth = seen_depth(functions_.point, landmark.y,
                                     state.covariance.block(landmark.y_block, landmark.y_block));
  if (!landmark.is_free() && depth.sigma < kKnownDepth * std::abs(depth.inverse_depth)) {
    settled_.insert(track);
  }
}

LandmarkVector Linearisation::at_rest(const Eigen::Vector3d& y) const {
  return landmark_state(y, MotionVector::Zero(functions_.motion));
}

NewLandmark Linearisation::birth(const JointState& state, const Camera& camera,
                                 const Observation& z, int frame, const NewLandmark& here) {
  if (at_estimate()) return here;
  if (kind_ == Kind::kIdeal && !camera_) camera_ = true_camera(*truth_, frame);
  const CameraState at = this->camera(state);
  anchors_.try_emplace(frame, at.position);
  Eigen::Vector2d pixel = z.pixel;
  std::optional<LandmarkVector> truth;
  if (kind_ == Kind::kIdeal) truth = true_state(*truth_, functions_, z.track, frame, at.position);
  if (truth) {
    const auto h = observe(camera, functions_.point, at.position, at.orientation, at.position,
                           Eigen::Vector3d(truth->head<3>()));
    if (h) pixel = h->pixel;
  }
  const auto born = initialise(camera, functions_.point, at.orientation, pixel,
                               functions_.point.inverse_depth(here.y));
  NewLandmark result = born ? *born : here;
  landmarks_[z.track] = truth ? *truth : at_rest(result.y);
  return result;
}

NewKnownLandmark Linearisation::known_birth(const JointState& state, const KnownLandmark& known,
                                            int frame, const NewKnownLandmark& here) {
  has_known_ = true;
  if (at_estimate()) return here;
  if (kind_ == Kind::kIdeal && !camera_) camera_ = true_camera(*truth_, frame);
  const Eigen::Vector3d anchor = anchors_.try_emplace(frame, camera(state).position).first->second;
  std::optional<LandmarkVector> truth;
  if (kind_ == Kind::kIdeal) truth = true_state(*truth_, functions_, known.track, frame, anchor);
  landmarks_[known.track] = truth ? *truth : at_rest(here.y);
  if (!truth) return here;
  const Eigen::Vector3d position = position_world(functions_.point, anchor, truth->head<3>());
  return initialise_known(functions_.point, {known.track, position, known.sigma}, anchor);
}

void Linearisation::forget_what_left(const JointState& state) {
  std::erase_if(anchors_, [&](const auto& a) { return !state.anchors.contains(a.first); });
  std::erase_if(landmarks_, [&](const auto& l) { return !state.landmarks.contains(l.first); });
  std::erase_if(settled_, [&](int track) { return !state.landmarks.contains(track); });
}

namespace {

// dy of a landmark whose direction turns by c: dy/dc.
Eigen::Matrix3d turned(const PointFunctions& point, const Eigen::Vector3d& y) {
  const PointRay ray = point.ray(y);
  const Matrix34d J = point.of_jacobian(ray.direction, ray.inverse_depth);
  return -J.leftCols<3>() * hat(ray.direction);
}

// The rows of B, of a w (velocity, acceleration: each three numbers turn with the world) at `from`
// that is expressed at `to`.
void turn_motion(StateBlock w, const MotionVector& from, const MotionVector& to,
                 Eigen::MatrixXd& B) {
  for (int k = 0; k + 3 <= w.dim; k += 3) {
    B.middleRows<3>(w.offset + k) = hat(Eigen::Vector3d((from - to).segment<3>(k)));
  }
}

// A turn c of the world moves what stands at p by c x p = -hat(p) c. With errors e = dp - c x p, c
// = R dtheta, an update only moves the estimate and leaves their covariance. In our coordinates
// that is dp := dp + (hat(p) - hat(p+)) c for every block, and its like for directions; dtheta
// itself is turned into the new camera frame.
void invariant_reset(const PointFunctions& point, const JointState& before, JointState& after) {
  JointCovariance& P = after.covariance;
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(P.size(), 3);
  const auto moved = [&](int offset, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    B.middleRows<3>(offset) = hat(Eigen::Vector3d(from - to));
  };
  moved(kPosition, before.camera.position, after.camera.position);
  moved(kVelocity, before.camera.velocity, after.camera.velocity);
  for (const auto& [frame, anchor] : after.anchors) {
    moved(anchor.block.offset, before.anchors.at(frame).position, anchor.position);
  }
  for (const auto& [track, landmark] : after.landmarks) {
    const FilterLandmark& old = before.landmarks.at(track);
    B.middleRows<3>(landmark.y_block.offset) = turned(point, landmark.y) - turned(point, old.y);
    if (landmark.is_free()) turn_motion(landmark.w_block, old.w, landmark.w, B);
  }
  const Eigen::Matrix3d R = before.camera.orientation.toRotationMatrix();
  P.add_dependence({kRotation, 3}, B * R);
  P.transform({{kRotation, 3}}, after.camera.orientation.conjugate().toRotationMatrix() * R);
}

}  // namespace

void Linearisation::collapse(JointState& state, std::span<const int> tracks) {
  if (scale_) scale_->collapse(state, tracks);
  if (kind_ != Kind::kInvariant) return;
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(state.covariance.size(), 3);
  for (const int track : tracks) {
    const FilterLandmark& landmark = state.landmarks.at(track);
    turn_motion(landmark.w_block, landmark.w, MotionVector::Zero(landmark.w.size()), B);
  }
  state.covariance.add_dependence({kRotation, 3}, B * state.camera.orientation.toRotationMatrix());
}

void Linearisation::prepare_alone(const JointState& state) {
  if (scale_) scale_->prepare(state);
}

void Linearisation::correct(JointState& state, Eigen::Ref<const Eigen::VectorXd> dx) {
  if (scale_) {
    scale_->correct(state, dx);
  } else if (kind_ == Kind::kStandard) {
    state.correct(dx);
  } else if (kind_ == Kind::kInvariant) {
    const JointState before{state.camera, state.scene, state.anchors, state.landmarks, {}, {}, {}};
    state.move(dx);
    invariant_reset(functions_.point, before, state);
  } else {
    state.move(dx);
  }
}

}  // namespace slammot
