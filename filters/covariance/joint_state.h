// The joint state chi = (camera, anchors, landmarks) of the EKF, thesis (2.1), with its covariance.
//
// Landmarks initialised in one frame share one anchor: its rows are identical for all of them for
// ever, so they are stored once. Layout of the error state: camera 12, the scene's depth (1) when
// it is to be learnt, poses of past frames (6 each) where a lag is asked for, then in any order an
// anchor (3), the y of a landmark (3), the w of a free one, and what is remembered of the
// constrained motion of a static one.
#pragma once

#include <map>
#include <optional>
#include <span>

#include "filters/covariance/joint_covariance.h"
#include "models/landmarks/landmark.h"

namespace slammot {

struct FilterAnchor {
  Eigen::Vector3d position;
  StateBlock block;
  int landmarks = 0;  // how many use it
};

struct FilterLandmark {
  int anchor = 0;     // key of JointState::anchors
  int last_used = 0;  // the frame, counted by the filter
  Eigen::Vector3d y;  // position, of the point parametrisation
  MotionVector w;     // motion, of the landmark model; empty when static
  StateBlock y_block;
  StateBlock w_block;  // empty when static

  // Static, but what its motion would be is remembered (constrained_motion.cpp): the rows of the
  // block are minus the information of w, and the state's sensitivity to w; beside them the
  // information vector. y is then that of the time at which it came to rest.
  StateBlock constrained_block;
  MotionVector information_vector;
  double rest_time = 0.0;  // [s], counted by the filter

  bool is_constrained() const { return constrained_block.dim > 0; }
  bool is_free() const { return w_block.dim > 0; }
  int dim() const { return y_block.dim + w_block.dim; }
  LandmarkVector x() const { return landmark_state(y, w); }
};

// The mean inverse depth of the scene at first sight, when it is to be learnt: all landmarks'
// priors share its error (LandmarkPrior::mean_sigma).
struct FilterScene {
  double inverse_depth = 0.0;
  StateBlock block;  // 1
};

// A pose in the state. Of a past frame, measurements go on correcting it through its covariance
// with the rest.
struct FilterPose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  StateBlock block;  // 6: dr (W), dtheta (C, right)
};

struct JointState {
  CameraState camera;
  std::optional<FilterScene> scene;
  std::map<int, FilterAnchor> anchors;      // by the index of the frame that initialised them
  std::map<int, FilterLandmark> landmarks;  // by track
  JointCovariance covariance;
  std::vector<FilterPose> clones;  // a ring; their rows stand behind those of the scene
  double time = 0.0;               // of the camera, since the first frame [s]

  static constexpr StateBlock kCamera{0, kCameraDim};
  static constexpr StateBlock kPose{0, 6};

  // x := x [+] dx for the whole state. P is then expressed in the coordinates at the new estimate:
  // the error of the rotation is multiplied by the right Jacobian of its correction.
  void correct(Eigen::Ref<const Eigen::VectorXd> dx);

  // The same without touching P: for an iterate, or where P stays at fixed points.
  void move(Eigen::Ref<const Eigen::VectorXd> dx);

  int size() const { return covariance.size(); }  // rows of the error state

  // The covariance of (anchor, y, w) of a landmark, and of any blocks.
  Eigen::MatrixXd marginal(const FilterLandmark& landmark) const;
  Eigen::MatrixXd marginal(std::span<const StateBlock> blocks) const;

  // This clone becomes a copy of the camera's pose.
  void clone_pose(FilterPose& clone);

  // Removes landmarks, and anchors that nobody uses any more.
  void remove_landmarks(std::span<const int> tracks);

  // A landmark becomes static: its motion is dropped from the state (its rows are marginalised).
  void drop_motion(int track);

  // A static landmark is free again, with w ~ N(0, diag(sigmas)^2).
  void free_motion(int track, const MotionVector& sigmas);

  // constrained_motion.cpp. After w = 0 was used as a measurement: the rows of w become those that
  // remember it. `sensitivity` is P[:, w] P_ww^-1, `information` P_ww^-1 and `vector` P_ww^-1 w.
  void constrain_motion(int track, const Eigen::MatrixXd& sensitivity,
                        const Eigen::MatrixXd& information, const Eigen::VectorXd& vector);
  // As if w = 0 of these landmarks had never been used, and y is moved on by F_yw w. Returns the
  // correction of the state, to be made. Throws Diverged where w is not determined.
  struct Released {
    int track = 0;
    Eigen::MatrixXd F_yw;
  };
  Eigen::VectorXd release_motions(std::span<const Released> released);
  void forget_motion(int track);

 private:
  // The rows of `from` are now those of `to`.
  void follow(StateBlock from, StateBlock to);
  void remove_motion(MotionVector& numbers, StateBlock& block);
  void remove_block(StateBlock block);
  bool is_last(int dim) const;  // whether the last rows are one block of this size
};

}  // namespace slammot
