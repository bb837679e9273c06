// The EKF of the thesis: joint covariance of camera and all landmarks, undelayed initialisation. A
// belief of the frame loop (estimation/loop/frame_loop.h); the functions stand in the order of a
// frame. How the rows of a landmark begin, move and end is in landmarks.cpp; the covariance of any
// block, in covariance/.
#pragma once

#include "estimation/belief.h"
#include "filters/devices.h"
#include "filters/ekf_options.h"
#include "filters/update.h"

namespace slammot {

class Ekf final : public Belief {
 public:
  // The options are those that check_options() lets pass.
  Ekf(const Setup& setup, const ModelOptions& models, const EkfOptions& options);

  void forget_motions(std::span<const int> tracks) override;
  void predict(const Frame& frame, double dt, const MotionNoise& noise,
               const TrackRecords& records) override;
  void add_known(const KnownLandmark& known) override;
  void innovations(std::span<const Observation> measured, FrameInnovation& result) override;
  void widen(double factor) override;
  void predict_pixels(std::span<const int> tracks, std::vector<Prediction>& result) override;
  void update(std::span<const Observation> accepted, std::span<const int> considered,
              StageListener& stages) override;
  void leave_one_out(std::vector<LeaveOneOut>& result) override;
  void inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) override;
  void motions(std::span<const int> tracks, std::vector<MotionBelief>& result) override;
  void collapse(std::span<const int> tracks) override;
  bool remembers_motions() const override { return remembers_; }
  void constrained_motions(std::span<const int> tracks, RememberedMotions& result) override;
  void free(int track, const LandmarkPrior& prior) override;
  void release(std::span<const int> tracks, const TrackRecords& records) override;
  void remove(std::span<const int> tracks, const TrackRecords& records) override;
  bool add(const FirstSight& seen, const LandmarkPrior& prior, bool is_free) override;
  void finish() override;

  void in_force(InForce& result) const override;
  int state_size() const override { return state_.size(); }
  CameraEstimate camera() const override;
  std::optional<PoseEstimate> pose_before(int frames) const override;
  void points(std::vector<LandmarkPoint>& result) override;
  std::vector<LandmarkBelief> landmarks(std::span<const int> tracks) const override;

  const JointState& state() const { return state_; }

 private:
  FilterPose& clone_of(int frame);

  // landmarks.cpp: their rows.
  void predict_landmark(int track, FilterLandmark& landmark, Label label, double dt);
  void condition_on_rest(std::span<const int> tracks);
  StateBlock append_new(const FirstSight& seen, const NewLandmark& at, const LandmarkPrior& prior,
                        int dim);
  FilterAnchor& anchor_here();
  void insert(int track, const Eigen::Vector3d& y, StateBlock block);

  Setup setup_;
  Rig rig_;
  EkfOptions options_;
  Gauge gauge_;  // that is asked for
  const LandmarkFunctions& functions_;
  bool condition_;  // on collapse, w = 0 is used
  bool remembers_;  // and what the motion would be is remembered
  Devices devices_;
  JointState state_;
  int frame_ = 0;                               // Frame::index of the newest
  int frames_ = 0;                              // predicted so far
  long updates_ = 0;                            // that had measurements
  Matrix12d camera_noise_ = Matrix12d::Zero();  // of the newest step

  // Of the frame in hand; kept for their memory.
  Innovation innovation_, of_considered_;
  std::vector<Observation> counting_, considered_;
};

// Throws std::invalid_argument for options that exclude each other.
void check_options(const EkfOptions& options);

// Throws std::invalid_argument for an unknown landmark model or classifier, or options that exclude
// each other.
std::unique_ptr<Estimator> make_ekf(const Setup& setup, const ModelOptions& models,
                                    const EkfOptions& options);

}  // namespace slammot
