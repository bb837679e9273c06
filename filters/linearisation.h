// Where the EKF takes its Jacobians, and whether it states what they leave out (second_order.h);
// innovations and predictions are always at the estimate.
//
// `standard`: at the newest estimate. An update keeps what is known of the scale (scale_error.h).
//
// `fej`: at first estimates (Huang, Mourikis & Roumeliotis 2008). What is predicted (camera, free
// landmarks) where it was predicted to be, anchors where they were initialised, static landmarks
// where they were when their depth was first known to a tenth: at its birth a depth is a guess, and
// fixed there everything diverges. Anchors and settled landmarks then have one point for ever. The
// camera's F is not matched to the points on both sides of a prediction, so a heading is still
// invented.
//
// `ideal`: at the truth, in simulation only. There nothing is left out.
//
// `invariant`: at the newest estimate, but the errors of everything in W are taken to turn with the
// camera's error (right-invariant error, Barrau & Bonnabel 2015). A heading that nobody has
// measured is then the same direction of the error before and after an update, and no update seems
// to measure it.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <span>

#include "filters/covariance/joint_state.h"
#include "filters/ekf_options.h"
#include "filters/scale_error.h"
#include "models/landmarks/landmark_models.h"
#include "models/points/initialisation.h"
#include "models/truth.h"

namespace slammot {

class Linearisation {
 public:
  // `any_known`: whether landmarks are known beforehand. Throws std::invalid_argument for `ideal`
  // without a truth.
  Linearisation(const EkfOptions& options, const LandmarkFunctions& landmark,
                std::shared_ptr<const Truth> truth, bool any_known = false);

  // Jacobians are taken at the estimate.
  bool at_estimate() const { return kind_ == Kind::kStandard || kind_ == Kind::kInvariant; }

  bool at_truth() const { return kind_ == Kind::kIdeal; }

  // Whether movers may correct themselves alone (EkfOptions::static_enough): `invariant` changes
  // the coordinates of all with each update, and Jacobians at the truth need no such care.
  bool movers_may_move_alone() const { return kind_ == Kind::kStandard || kind_ == Kind::kFej; }

  bool has_second_order() const { return second_order_ && !at_truth(); }
  // Whether N has blocks beside its diagonal: once a known landmark has been measured
  // (second_order.h).
  bool has_common_second_order() const { return has_second_order() && has_known_; }

  const PointFunctions& point() const { return functions_.point; }
  CameraState camera(const JointState& state) const;
  Eigen::Vector3d anchor(const JointState& state, int frame) const;
  LandmarkVector landmark(const JointState& state, int track) const;

  // Whether the landmark's point no longer asks for its covariance.
  bool is_settled(int track) const { return kind_ != Kind::kFej || settled_.contains(track); }

  // The state was predicted to the frame `frame`, dt after the one before.
  void predicted(const JointState& state, int frame, double dt);

  // A landmark is about to be initialised: its Jacobians, and its point from now on. `here` is what
  // initialise() gives at the estimate.
  NewLandmark birth(const JointState& state, const Camera& camera, const Observation& z, int frame,
                    const NewLandmark& here);
  NewKnownLandmark known_birth(const JointState& state, const KnownLandmark& known, int frame,
                               const NewKnownLandmark& here);

  // w = 0 is about to be used as a measurement. `invariant`: a turn of the world leaves 0 where it
  // is, so the errors of w are expressed there. Elsewhere w = 0 would seem to tell the heading. So
  // it is with the scale.
  void collapse(JointState& state, std::span<const int> tracks);

  // x := x [+] dx after an update or a collapse. Only `standard` re-expresses P at the new
  // estimate: elsewhere its coordinates are those of the fixed points.
  void correct(JointState& state, Eigen::Ref<const Eigen::VectorXd> dx);

  // Before landmarks are corrected alone.
  void prepare_alone(const JointState& state);
  // None where the scale's errors are not kept.
  ScaleError* scale() { return scale_ ? &*scale_ : nullptr; }

 private:
  using Kind = FilterLinearisation;

  LandmarkVector at_rest(const Eigen::Vector3d& y) const;
  void predicted_first_estimate(const JointState& state, int track);
  void forget_what_left(const JointState& state);

  Kind kind_;
  bool second_order_;
  bool has_known_ = false;  // a known landmark was born
  const LandmarkFunctions& functions_;
  std::shared_ptr<const Truth> truth_;
  std::optional<ScaleError> scale_;
  std::optional<CameraState> camera_;  // none before the first prediction: the estimate
  std::map<int, Eigen::Vector3d> anchors_;
  std::map<int, LandmarkVector> landmarks_;
  std::set<int> settled_;  // fej: static landmarks whose point no longer moves
};

}  // namespace slammot
