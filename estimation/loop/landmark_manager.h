// Landmarks from birth to pruning, the same for every estimator family: which measurements become
// landmarks, how each is labelled, when a label is reverted, and when a landmark is pruned. It
// holds the records and the policies; what is believed it asks of the belief.
#pragma once

#include <memory>
#include <set>

#include "estimation/belief.h"
#include "estimation/labels/first_frame.h"

namespace slammot {

class LandmarkManager {
 public:
  // `truth_for_view`: none, or the truth of a run whose Jacobians are taken there.
  // Throws std::invalid_argument for an unknown landmark model, classifier or policy.
  LandmarkManager(const Setup& setup, const ModelOptions& models, FirstFrame& first,
                  std::shared_ptr<const Truth> truth_for_view);

  const TrackRecords& records() const { return records_; }
  bool knows(int track) const { return records_.contains(track); }

  // In the order of the frame (frame_loop.cpp). `report` counts what happened.
  void retire_leaving(Belief& belief, FrameReport& report);
  void add_known(const Frame& frame, Belief& belief, FrameReport& report);
  void record(int frame, std::span<const Observation> accepted, std::span<const int> unused);
  bool watches_innovations() const { return slammot::watches_innovations(models_.labels); }
  void note_innovations(std::span<const LeaveOneOut> innovations);
  void look_at_depths(std::span<const Observation> accepted, Belief& belief);
  // Tracks whose probation ends with this frame become landmarks, before its measurements are
  // gated.
  void end_probation(const Frame& frame, Belief& belief, FrameReport& report);
  // Returns the tracks that are static from now on.
  const std::vector<int>& classify(int frame, std::span<const Observation> accepted,
                                   Belief& belief);
  void revert_labels(std::span<const Observation> measured, Belief& belief);
  void prune(int frame, Belief& belief, FrameReport& report);
  void initialise_new(const Frame& frame, Belief& belief, FrameReport& report);

  // The estimates of these landmarks, in this order.
  std::vector<LandmarkEstimate> estimates(std::span<const int> tracks, const Belief& belief) const;

 private:
  void release_what_moved(Belief& belief);  // motions_
  void complete_motions(std::span<const Observation> measured);
  Label answer(const MotionBelief& motion, TrackRecord& record) const;
  void remove(Belief& belief, FrameReport& report);  // tracks_
  TrackRecord record_at_birth(int track, int frame, const LandmarkPrior& prior);
  bool expected_in_view(int frame, const CameraState& camera, const LandmarkPoint& point) const;

  Setup setup_;
  ModelOptions models_;
  const LandmarkFunctions& functions_;
  std::unique_ptr<Classifier> classifier_;
  DepthPrior depth_prior_;
  std::shared_ptr<const Truth> truth_;
  std::map<int, KnownLandmark> known_;  // stated, not measured yet
  Probation probation_;
  FirstFrame& first_;
  std::optional<int> first_frame_;
  TrackRecords records_;
  std::map<int, Label> labels_left_;  // of landmarks that the belief could not keep

  // Of the frame in hand; kept for their memory.
  std::vector<int> tracks_, now_static_;
  std::vector<SeenDepth> depths_;
  std::vector<MotionBelief> motions_;
  std::vector<LandmarkPoint> points_;
  std::vector<Observation> unmatched_;
};

}  // namespace slammot
