// The joint state chi = (camera, anchors, landmarks) of the EKF, thesis (2.1), with its covariance.
//
// Landmarks born in one frame share one anchor: its rows are identical for all of them for ever, so
// they are stored once. Layout of the error state: camera 12, then anchors (3) and landmarks (3
// when static, 6 when free: y, w) in the order of their births.
#pragma once

#include <map>
#include <optional>

#include "slammot/filters/joint_covariance.h"
#include "slammot/models/camera_state.h"
#include "slammot/models/track_policy.h"

namespace slammot {

struct FilterAnchor {
  Eigen::Vector3d position;
  StateBlock block;
  int landmarks = 0;  // how many use it
};

struct FilterLandmark {
  TrackRecord record;
  int anchor = 0;                               // key of JointState::anchors
  Eigen::Vector3d y;                            // (theta, phi, rho)
  Eigen::Vector3d w = Eigen::Vector3d::Zero();  // motion, of the landmark model; zero when static
  StateBlock block;

  bool is_free() const { return block.dim == 6; }
  StateBlock y_block() const { return {block.offset, 3}; }
  StateBlock w_block() const { return {block.offset + 3, 3}; }
  Vector6d x() const { return (Vector6d() << y, w).finished(); }
};

// The mean inverse depth of the scene at first sight, when it is to be learnt: all landmarks'
// priors share its error (LandmarkPrior::mean_sigma).
struct FilterScene {
  double inverse_depth = 0.0;
  StateBlock block;  // 1
};

struct JointState {
  CameraState camera;
  std::optional<FilterScene> scene;
  std::map<int, FilterAnchor> anchors;      // by the index of the frame they were born in
  std::map<int, FilterLandmark> landmarks;  // by track
  JointCovariance covariance;

  static constexpr StateBlock kCamera{0, kCameraDim};
  static constexpr StateBlock kPose{0, 6};

  // x := x [+] dx for the whole state. P is then expressed in the coordinates at the new estimate:
  // the error of the rotation is multiplied by the right Jacobian of its correction.
  void correct(const Eigen::VectorXd& dx);

  // The same without touching P: for an iterate.
  void move(const Eigen::VectorXd& dx);

  // Removes landmarks, and anchors that nobody uses any more.
  void remove_landmarks(const std::vector<int>& tracks);

  // Landmarks become static: their motion is dropped from the state (its rows are marginalised).
  void drop_motion(const std::vector<int>& tracks);

  // A static landmark is free again, with w ~ N(0, sigma^2 I).
  void free_motion(int track, double sigma);

 private:
  void remove_blocks(std::vector<StateBlock> blocks);
};

}  // namespace slammot
