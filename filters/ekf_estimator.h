// The EKF's state and the steps of its frame; see ekf.h for what it is.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "estimation/classification.h"
#include "estimation/depth_prior.h"
#include "filters/ekf.h"
#include "filters/ekf_update.h"

namespace slammot {

class Ekf final : public Estimator {
 public:
  // Throws std::invalid_argument for an unknown landmark model, classifier, linearisation or
  // source of the depth prior.
  Ekf(const Setup& setup, const ModelOptions& models, const EkfOptions& options);

  FrameReport process(const Frame& frame, StageListener& stages) override;
  CameraEstimate camera() const override;
  std::vector<LandmarkEstimate> landmarks() const override;
  std::vector<LandmarkEstimate> landmarks_measured(int index) const override;

  const JointState& state() const { return state_; }

 private:
  // ekf.cpp: the frame.
  void predict(const Frame& frame);
  void correct();
  void check() const;

  // ekf_far.cpp: what of the map is near.
  void divide(const Frame& frame);
  void rest();
  int find_resting();

  // ekf_landmarks.cpp: the life of landmarks.
  void admit_known(const Frame& frame, FrameReport& report);
  void admit_new(const Frame& frame, FrameReport& report);
  StateBlock append_new(const NewLandmark& at, const LandmarkPrior& prior, int dim);
  FilterAnchor& anchor_here(int frame);
  FilterLandmark& add(TrackRecord record, const Eigen::Vector3d& y, StateBlock block, int frame);
  // What became of each landmark's measurement, into its record.
  void note(int frame);
  void learn_depths();
  void classify(int frame);
  void collapse();  // of those that classify() found static
  void testify();   // what this frame's measurements say of the static labels
  // Takes back static labels that the innovations of this frame reject.
  void take_back();
  void retire(FrameReport& report);
  LandmarkEstimate estimate(const FilterLandmark& landmark) const;

  Setup setup_;
  ModelOptions models_;
  EkfOptions options_;
  const LandmarkFunctions& landmark_;
  std::unique_ptr<Classifier> classifier_;
  DepthPrior depth_prior_;
  std::vector<SeenDepth> seen_;  // learn_depths()
  std::map<int, KnownLandmark> known_;
  std::set<int> known_used_;
  JointState state_;
  Linearisation linearisation_;
  std::optional<double> timestamp_;
  int first_frame_ = 0;     // index of the first frame processed
  double overspent_ = 0.0;  // since the last fold, by `deferred`

  // Of the frame in hand; kept for their memory.
  std::vector<Match> matches_, accepted_, pending_;
  std::vector<int> out_of_view_;  // tracks
  std::vector<double> testimony_;
  Innovation innovation_;
  Gate gate_;
  std::vector<Observation> unmatched_;
  std::vector<int> tracks_;   // now static, lost, or to rest
  std::vector<int> anchors_;  // of landmarks that stay near
};

}  // namespace slammot
