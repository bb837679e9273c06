// Landmarks from birth to pruning, the same for every estimator family: which measurements become
// landmarks, how each is labelled, when a label is undone, and when a landmark is pruned. It
// holds the records and the policies; what is believed it asks of the belief.
#pragma once

#include <memory>

#include "estimation/belief.h"
#include "estimation/modules/label_revision.h"
#include "estimation/modules/outside_odds.h"

namespace slammot {

class LandmarkManager {
 public:
  // `remembers`: Belief::remembers_motions(). `truth_of_jacobians`: none, or the truth of a run
  // whose Jacobians are taken there. Throws std::invalid_argument for an unknown landmark model,
  // classifier or policy.
  LandmarkManager(const Setup& setup, const ModelOptions& models, bool remembers,
                  std::shared_ptr<const Truth> truth_of_jacobians);

  const TrackRecords& records() const { return records_; }
  bool holds(int track) const { return records_.contains(track); }

  // In the order of the frame (frame_loop.cpp). `report` counts what happened.
  void forget_motions(Belief& belief);
  void add_known(const Frame& frame, Belief& belief, FrameReport& report);
  bool watches_innovations() const { return slammot::watches_innovations(models_.labels); }
  void note_innovations(std::span<const LeaveOneOut> innovations);
  void look_at_depths(std::span<const Observation> accepted, Belief& belief);
  void record(int frame, std::span<const Observation> accepted, std::span<const int> unused);
  // Into now_static(): the tracks that are static from now on.
  void classify(int frame, std::span<const Observation> accepted, Belief& belief);
  const std::vector<int>& now_static() const { return now_static_; }
  // Free landmarks become static, (3.3).
  void collapse(std::span<const int> tracks, Belief& belief);
  // Landmarks at rest whose label must be undone are free again, and those held by their births get
  // their label (label_revision.h).
  void undo_labels(int frame, std::span<const Observation> measured, Belief& belief);
  void prune(int frame, Belief& belief, FrameReport& report);
  // `visible`: landmarks measured in this frame, those that passed the gate.
  void initialise_new(const Frame& frame, int visible, Belief& belief, FrameReport& report);

  // The shared mechanisms of labels, depths and births; see in_force.h.
  void in_force(InForce& result) const;

  // The estimates of these landmarks, in this order.
  std::vector<LandmarkEstimate> estimates(std::span<const int> tracks, const Belief& belief) const;

 private:
  std::optional<MotionAnswer> ask_remembered(std::size_t i);
  void note_motions(int frame);
  void apply(const Undoing& undoing, Belief& belief);
  void complete(MotionBelief& motion) const;
  void state_outside(const std::string& at_rest, InForce& result) const;
  void state_births(const std::string& no_memory, InForce& result) const;
  Label answer(const MotionBelief& motion, TrackRecord& record) const;
  void remove(Belief& belief, FrameReport& report);  // tracks_
  FirstSight first_sight_of(const Frame& frame, const Observation& z, LandmarkPrior& prior) const;
  bool expected_in_view(int frame, const CameraState& camera, const LandmarkPoint& point) const;

  Setup setup_;
  ModelOptions models_;
  const LandmarkFunctions& functions_;
  Rig rig_;
  std::unique_ptr<Classifier> classifier_;
  OutsideOdds outside_;
  DepthPrior depth_prior_;
  std::shared_ptr<const Truth> truth_;
  std::map<int, KnownLandmark> known_;  // stated, not measured yet
  std::optional<int> first_frame_;
  TrackRecords records_;
  bool remembers_;
  int memory_;     // frames for which the motion of a static landmark is remembered
  Births births_;  // as they act
  long undone_ = 0, released_ = 0, answered_ = 0, collapsed_ = 0, learnt_ = 0, held_ = 0,
       let_go_ = 0, with_odds_ = 0;

  // Of the frame in hand; kept for their memory.
  std::vector<int> tracks_, now_static_;
  std::vector<SeenDepth> depths_;
  std::vector<MotionBelief> motions_;
  RememberedMotions remembered_;
  Undoing undoing_;
  std::vector<LandmarkPoint> points_;
  std::vector<Observation> unmatched_;
};

}  // namespace slammot
