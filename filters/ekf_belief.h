// The EKF's belief: the joint state with its full covariance; see ekf.h for what it is. The
// functions stand in the order of a frame, here, in ekf.cpp and in the window's files alike.
#pragma once

#include "estimation/belief.h"
#include "filters/ekf.h"
#include "filters/ekf_update.h"

namespace slammot {

class Ekf final : public Belief {
 public:
  // Throws std::invalid_argument for an unknown landmark model or linearisation, or options that
  // exclude each other.
  Ekf(const Setup& setup, const ModelOptions& models, const EkfOptions& options);

  void predict(const Frame& frame, double dt, const MotionNoise& noise,
               const TrackRecords& records) override;
  void add_known(const KnownLandmark& known) override;
  void innovations(std::span<const Observation> measured, FrameInnovation& result) override;
  void widen(double factor) override;
  void predict_pixels(std::span<const int> tracks, std::vector<Prediction>& result) override;
  void update(const TrackRecords& records, std::span<const Observation> accepted,
              StageListener& stages) override;
  void leave_one_out(std::vector<LeaveOneOut>& result) override;
  void inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) override;
  void motions(std::span<const int> tracks, std::vector<MotionBelief>& result) override;
  void collapse(std::span<const int> tracks) override;
  void held_motions(std::span<const int> tracks, std::vector<MotionBelief>& result) override;
  void free(int track, const LandmarkPrior& prior) override;
  void release(int track, const LandmarkPrior& prior) override;
  void remove(std::span<const int> tracks, const TrackRecords& records) override;
  bool add(const Observation& z, const LandmarkPrior& prior, bool is_free) override;
  void add_seen(std::span<const Candidate> candidates, std::vector<int>& refused) override;
  void finish() override;

  int state_size() const override { return state_.size(); }
  CameraEstimate camera() const override;
  std::optional<PoseEstimate> pose_before(int frames) const override;
  void points(std::vector<LandmarkPoint>& result) override;
  std::vector<LandmarkBelief> landmarks(std::span<const int> tracks) const override;

  const JointState& state() const { return state_; }

 private:
  void predict_landmark(int track, FilterLandmark& landmark, Label label, double dt);
  void predict_held(int track, const FilterLandmark& landmark, double dt);
  void forget_motions();
  void condition_on_rest(std::span<const int> tracks);
  FilterPose& clone_of(int frame);
  bool add(const Observation& z, const FilterPose& pose, int frame, const LandmarkPrior& prior,
           bool is_free);
  StateBlock append_new(const Observation& z, const NewLandmark& at, const FilterPose& pose,
                        const LandmarkPrior& prior, int dim);
  FilterAnchor& anchor_at(const FilterPose& pose, int frame);
  void insert(int track, int frame, const Eigen::Vector3d& y, StateBlock block);

  // ekf_probation.cpp
  bool add_seen(const Candidate& candidate);
  bool use_past(const FilterPose& pose, const Observation& z);

  bool moves_alone(Label label, std::ptrdiff_t static_measurements) const;

  // ekf_passive.cpp: what of the map is updated at once, with the option `deferred`.
  void divide(const Frame& frame);
  void deactivate();
  int find_passive();

  Setup setup_;
  EkfOptions options_;
  bool condition_;  // on collapse, w = 0 is used
  double threshold_given_others_;
  const LandmarkFunctions& functions_;
  int memory_;  // frames for which the motion of a static landmark is remembered
  JointState state_;
  Linearisation linearisation_;
  int frame_ = 0;                               // Frame::index of the newest
  int frames_ = 0;                              // predicted so far
  Matrix12d camera_noise_ = Matrix12d::Zero();  // of the newest step
  double overspent_ = 0.0;                      // since the last synchronisation, by `deferred`

  // Of the frame in hand; kept for their memory.
  Innovation innovation_, alone_;
  std::size_t measured_ = 0;  // how many were, in view
  std::vector<Observation> counting_, pending_;
  std::vector<double> nis_;
  std::vector<int> tracks_;   // to remove, or to deactivate
  std::vector<int> anchors_;  // of landmarks that stay active
};

}  // namespace slammot
