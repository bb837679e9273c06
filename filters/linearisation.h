// Where the EKF takes its Jacobians; innovations and predictions are always at the estimate.
//
// `standard`: at the newest estimate.
//
// `fej`: at first estimates (Huang, Mourikis & Roumeliotis 2008). What is predicted (camera, free
// landmarks) where it was predicted to be, anchors where they were initialised, static landmarks
// where they were when their depth was first known to a tenth: at its birth a depth is a guess, and
// fixed there everything diverges. Anchors and settled landmarks then have one point for ever. The
// camera's F is not matched to the points on both sides of a prediction, so a heading is still
// invented.
//
// `ideal`: at the truth, in simulation only. There nothing is left out.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <span>

#include "filters/covariance/joint_state.h"
#include "filters/ekf_options.h"
#include "models/landmarks/landmark_models.h"
#include "models/points/first_sight.h"
#include "models/points/initialisation.h"
#include "models/truth.h"

namespace slammot {

class Linearisation {
 public:
  // Throws std::invalid_argument for `ideal` without a truth.
  Linearisation(FilterLinearisation kind, const LandmarkFunctions& landmark,
                std::shared_ptr<const Truth> truth);

  // Jacobians are taken at the estimate.
  bool at_estimate() const { return kind_ == Kind::kStandard; }

  bool at_truth() const { return kind_ == Kind::kIdeal; }

  const PointFunctions& point() const { return functions_.point; }
  CameraState camera(const JointState& state) const;
  Eigen::Vector3d anchor(const JointState& state, int frame) const;
  LandmarkVector landmark(const JointState& state, int track) const;

  // The state was predicted to the frame `frame`, dt after the one before.
  void predicted(const JointState& state, int frame, double dt);

  // A landmark is about to be initialised: its Jacobians, and its point from now on. `here` is what
  // initialise() gives at the estimate.
  NewLandmark birth(const JointState& state, const Camera& camera, const FirstSight& seen,
                    int frame, const NewLandmark& here);
  NewKnownLandmark known_birth(const JointState& state, const KnownLandmark& known, int frame,
                               const NewKnownLandmark& here);

 private:
  using Kind = FilterLinearisation;

  LandmarkVector at_rest(const Eigen::Vector3d& y) const;
  void predicted_first_estimate(const JointState& state, int track);
  void forget_what_left(const JointState& state);

  Kind kind_;
  const LandmarkFunctions& functions_;
  std::shared_ptr<const Truth> truth_;
  std::optional<CameraState> camera_;  // none before the first prediction: the estimate
  std::map<int, Eigen::Vector3d> anchors_;
  std::map<int, LandmarkVector> landmarks_;
  std::set<int> settled_;  // fej: static landmarks whose point no longer moves
};

}  // namespace slammot
