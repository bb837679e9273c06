// What an estimator family believes: the joint Gaussian of camera and landmarks, and the few
// questions in which a filter and a smoother differ. Everything else of a frame is frame_loop.h and
// landmark_manager.h, the same for every family; a new family implements this interface and
// inherits gate, labels, depth prior and pruning.
//
// A landmark is named by its track. It is *free* while it has a motion w, else at rest; "static"
// below means that, whatever its label. Output parameters are replaced; they are handed in so that
// a warm frame asks for no memory. Every function may throw Diverged.
#pragma once

#include <span>
#include <stdexcept>
#include <vector>

#include "estimation/classification.h"
#include "estimation/estimator.h"
#include "estimation/gate.h"
#include "estimation/in_force.h"
#include "estimation/landmark_estimate.h"
#include "estimation/remembered_motions.h"
#include "estimation/seen_depth.h"
#include "estimation/track_policy.h"
#include "models/points/first_sight.h"

namespace slammot {

// The NIS of a landmark's measurements given those of all others of its frame (label_revision.h).
struct LeaveOneOut {
  int track = 0;
  double nis = 0.0;
  int pixels = 1;  // of two degrees of freedom each: one for each camera of a rig that measured it
};

// Where a landmark is believed to be.
struct LandmarkPoint {
  int track = 0;
  Eigen::Vector3d anchor;  // W [m]
  Eigen::Vector3d y;       // seen from the anchor (models/points/point.h)
};

class Belief {
 public:
  virtual ~Belief() = default;

  // The time update, thesis 2.1.1 and (2.5), by `dt` [s] since the frame before (0: the first
  // frame), with this noise of the camera. How much a landmark may accelerate depends on its label
  // (LandmarkPrior::noise).
  virtual void predict(const Frame& frame, double dt, const MotionNoise& noise,
                       const TrackRecords& records) = 0;

  // A landmark known beforehand enters as static, before the frame's measurements are used.
  virtual void add_known(const KnownLandmark& known) = 0;

  // Of measurements of landmarks in the belief; those not expected in view (observation.h) are left
  // out.
  virtual void innovations(std::span<const Observation> measured, FrameInnovation& result) = 0;

  // After innovations(): the camera's noise in the newest step has `factor` times the variance that
  // it has now. A factor below 1 takes an earlier call back. innovations() is asked again after
  // each call. A belief without it keeps its step.
  virtual void widen(double /*factor*/) {}

  // After innovations(), which it leaves as they are: where these landmarks are expected, of those
  // that are in view; S without the pixels' noise. For who draws: nothing of an estimate may depend
  // on it.
  virtual void predict_pixels(std::span<const int> /*tracks*/, std::vector<Prediction>& result) {
    result.clear();
  }

  // The measurement update with what passed the gate, a part of innovations() in its order.
  // Measurements of the tracks in `considered` (modules/consider.h), sorted, correct their own
  // landmarks and nothing else. A smoother first lets the oldest frame leave.
  virtual void update(std::span<const Observation> accepted, std::span<const int> considered,
                      StageListener& stages) = 0;

  // After update(): of its measurements, those of static landmarks at least.
  virtual void leave_one_out(std::vector<LeaveOneOut>& result) = 0;

  // Marginals of landmarks that update() used: rho of static ones at first sight, w of free ones.
  // The manager fills in MotionBelief::prior_sigmas and outside.
  virtual void inverse_depths(std::span<const int> tracks, std::vector<SeenDepth>& result) = 0;
  virtual void motions(std::span<const int> tracks, std::vector<MotionBelief>& result) = 0;

  // Free landmarks become static, (3.3), as ModelOptions::collapse says: w is marginalised, or w =
  // 0 is used as a measurement.
  virtual void collapse(std::span<const int> tracks) = 0;

  // Whether it can say what the motions of landmarks at rest would be; without, labels are undone
  // by innovations alone, and no birth is held (modules/births.h).
  virtual bool remembers_motions() const { return false; }

  // What the motions of these landmarks at rest, measured in this frame, would be, were they not
  // held at rest; of those whose motion is still remembered (LabelOptions::memory).
  virtual void constrained_motions(std::span<const int> /*tracks*/, RememberedMotions& result) {
    result.reset(0, 0);
  }

  // Before predict(): the motions of these static landmarks are remembered no longer
  // (modules/label_revision.h).
  virtual void forget_motions(std::span<const int> /*tracks*/) {}

  // Static landmarks whose motion is remembered are free again as if they had never been static:
  // what their rest has done to the others is undone.
  virtual void release(std::span<const int> tracks, const TrackRecords& records) {
    for (const int track : tracks) free(track, records.at(track).prior);
  }

  // A static landmark is free again from this frame on, its motion's prior restored.
  virtual void free(int track, const LandmarkPrior& prior) = 0;

  virtual void remove(std::span<const int> tracks, const TrackRecords& records) = 0;

  // A landmark enters at its first pixel, thesis 2.1.3, or with all that its first frame says of it
  // (first_sight.h). False when the pixel has no ray. Its inverse depth has the prior of `seen`,
  // its motion that of `prior`. With Setup::prior.mean_sigma > 0 the mean of the inverse depths is
  // a variable of the belief, and used instead where the depth is not its own.
  virtual bool add(const FirstSight& seen, const LandmarkPrior& prior, bool is_free) = 0;

  // At the end of a frame, whatever is left to check.
  virtual void finish() {}

  // What of this family's own devices acts; see in_force.h. The loop adds those that are shared.
  virtual void in_force(InForce& /*result*/) const {}

  virtual int state_size() const = 0;  // of the error state
  // See FrameReport::scale_information.
  virtual double scale_information() const { return kUndefined; }
  virtual CameraEstimate camera() const = 0;
  // See Estimator::pose_before().
  virtual std::optional<PoseEstimate> pose_before(int /*frames*/) const { return std::nullopt; }
  virtual void points(std::vector<LandmarkPoint>& result) = 0;  // of all landmarks, by track
  virtual std::vector<LandmarkBelief> landmarks(std::span<const int> tracks) const = 0;

  // See Estimator::smoothed().
  virtual std::vector<CameraEstimate> smoothed() { return {}; }
};

}  // namespace slammot
