// One frame of the thesis's algorithm (chapters 2 and 3), the same for every estimator family: a
// difference in the result is a difference between beliefs.
//
// Stages, as a StageListener hears them: predict, gate, update (a smoother
// marginalises first), marginals, classify, collapse, manage; after the gate, predictions, where
// they are kept.
#pragma once

#include <memory>

#include "estimation/belief.h"
#include "estimation/gate.h"
#include "estimation/loop/landmark_manager.h"
#include "estimation/modules/camera_noise.h"
#include "estimation/modules/lasting_errors.h"
#include "estimation/modules/scale_change.h"

namespace slammot {

class FrameLoop final : public Estimator {
 public:
  // `belief`: before the first frame. `truth_of_jacobians`: see LandmarkManager. Throws
  // std::invalid_argument as that does.
  FrameLoop(const Setup& setup, const ModelOptions& models, std::unique_ptr<Belief> belief,
            std::shared_ptr<const Truth> truth_of_jacobians = nullptr);

  void keep_predictions() override { keeps_predictions_ = true; }
  FrameReport process(const Frame& frame, StageListener& stages) override;
  CameraEstimate camera() const override;
  std::optional<PoseEstimate> pose_before(int frames) const override {
    return belief_->pose_before(frames);
  }
  std::vector<LandmarkEstimate> landmarks() const override;
  std::vector<LandmarkEstimate> landmarks_measured(int index) const override;
  std::vector<CameraEstimate> smoothed(StageListener& /*stages*/) override {
    return belief_->smoothed();
  }

  InForce in_force() const override;

  const TrackRecords& records() const { return manager_.records(); }

 private:
  // Of the frame's static landmarks: whether most agree with the accepted measurements, and the
  // median NIS, of those that agree if they are most.
  struct Agreement {
    bool most_agree = false;
    double median_nis = 0.0;
  };

  double advance_time(const Frame& frame);
  void gate(const Frame& frame, double dt, FrameReport& report);
  void find_measured(const Frame& frame);
  void split_by_gate(double dt, FrameReport& report);
  void sort_landmarks();
  void drop_explained_of_used();
  void follow_jolt(bool may_widen);
  void scale_step(double factor);
  Agreement agreement();
  void note_predictions(FrameReport& report);
  void look_at_marginals(const CameraEstimate& before, double dt);
  void count_what_is_left(FrameReport& report);

  Setup setup_;
  ModelOptions models_;
  const PointFunctions& point_;
  FrameGate gate_;
  TrackPolicy policy_;  // as it acts
  bool keeps_predictions_ = false;

  std::unique_ptr<Belief> belief_;
  LandmarkManager manager_;
  AdaptiveCameraNoise noise_;
  LastingErrors lasting_;
  std::optional<ScaleChange> scale_change_;  // where nothing measures the scale
  std::optional<double> timestamp_;
  // How often mechanisms have acted.
  long widened_ = 0, considered_frames_ = 0, refused_by_others_ = 0;

  // Of the frame in hand; kept for their memory.
  std::vector<Observation> measured_, in_view_, accepted_;
  // The first of each landmark, of those accepted, in view, and all.
  std::vector<Observation> used_, landmarks_in_view_, landmarks_measured_;
  std::vector<int> considered_;
  FrameInnovation innovation_;
  std::vector<LeaveOneOut> explained_by_motion_;  // rejected, but would pass had they moved
  std::vector<LeaveOneOut> given_others_;
  std::vector<int> unused_;  // tracks: rejected, or not expected in view
  std::vector<LandmarkPoint> points_;
  std::vector<double> nis_, nis_of_agreed_;  // of static landmarks
};

}  // namespace slammot
