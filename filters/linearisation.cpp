#include "filters/linearisation.h"

#include <stdexcept>

#include "estimation/seen_depth.h"
#include "models/landmarks/true_state.h"
#include "models/points/observation.h"

namespace slammot {

Linearisation::Linearisation(FilterLinearisation kind, const LandmarkFunctions& landmark,
                             std::shared_ptr<const Truth> truth)
    : kind_(kind), functions_(landmark), truth_(std::move(truth)) {
  if (kind_ == Kind::kIdeal && !truth_) {
    throw std::invalid_argument("linearisation ideal needs the exact truth of a simulation");
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
                                 const FirstSight& seen, int frame, const NewLandmark& here) {
  if (at_estimate()) return here;
  if (kind_ == Kind::kIdeal && !camera_) camera_ = true_camera(*truth_, frame);
  const CameraState at = this->camera(state);
  anchors_.try_emplace(frame, at.position);
  const int track = seen.z.track;
  Eigen::Vector2d pixel = seen.pixel;
  std::optional<LandmarkVector> truth;
  if (kind_ == Kind::kIdeal) truth = true_state(*truth_, functions_, track, frame, at.position);
  if (truth) {
    const auto h = observe(camera, functions_.point, at.position, at.orientation, at.position,
                           Eigen::Vector3d(truth->head<3>()));
    if (h) pixel = h->pixel;
  }
  const auto born = initialise(camera, functions_.point, at.orientation, pixel,
                               functions_.point.inverse_depth(here.y));
  NewLandmark result = born ? *born : here;
  landmarks_[track] = truth ? *truth : at_rest(result.y);
  return result;
}

NewKnownLandmark Linearisation::known_birth(const JointState& state, const KnownLandmark& known,
                                            int frame, const NewKnownLandmark& here) {
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

}  // namespace slammot
