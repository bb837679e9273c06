// The one interface between an estimator and everything that drives or judges it.
//
// An estimator is pure: no threads, files, clock, logging or globals. It is given frames in order
// and asked what it believes. Stage timing is taken from outside through StageListener.
#pragma once

#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "estimation/in_force.h"
#include "models/camera_motion.h"
#include "models/label.h"
#include "models/measurement.h"
#include "models/rig.h"
#include "models/truth.h"

namespace slammot {

inline constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

// The sequence's own statements, after the configuration has overridden them.
struct Setup {
  Camera camera;
  std::vector<MountedCamera> other_cameras;  // of a rig
  bool measures_scale = false;               // by another camera, or by depths at birth
  double pixel_sigma = 1.0;                  // [px]
  MotionNoise camera_noise;
  LandmarkPrior prior;
  InitialCamera initial;
  std::vector<KnownLandmark> known;
  std::map<int, double> p_static;      // by track, from outside (modules/outside_odds.h)
  std::map<int, Label> true_labels;    // by track; read by the classifier `truth` only
  std::shared_ptr<const Truth> truth;  // read by linearisation `ideal` only; may be none

  Rig rig() const { return {camera, other_cameras}; }
  // Whether anything but the camera's motion and guessed depths says how large the world is.
  bool knows_scale() const { return measures_scale || !known.empty(); }
};

struct CameraEstimate {
  double timestamp = 0.0;
  CameraState state;
  Matrix12d covariance = Matrix12d::Zero();  // of [dr (W), dtheta (C, right), dv (W), domega (C)]
};

// The pose of a frame that has passed, as all measurements since have corrected it.
struct PoseEstimate {
  Eigen::Vector3d position;
  Eigen::Quaterniond orientation;
  Eigen::Matrix<double, 6, 6> covariance;  // of [dr (W), dtheta (C, right)]
};

// One landmark as believed after the newest frame. What is not defined is NaN, never zero: the
// velocity of a landmark held static, and the position of one at infinity.
struct LandmarkEstimate {
  int track = 0;
  Label label = Label::kUnknown;
  bool by_rule = false;  // known, or static because it was in the first frame: nothing was decided
  int first_frame = 0;   // frame indices, as in Frame::index
  int last_frame = 0;    // of the newest measurement used
  std::optional<int> decision_frame;
  std::optional<int> state_frame;  // of position and velocity, where it is not the newest frame
  int observations = 0;            // measurements used, the first one included
  Eigen::Vector3d position = Eigen::Vector3d::Constant(kUndefined);  // W [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Constant(kUndefined);  // W [m/s]
  Eigen::Matrix3d position_covariance = Eigen::Matrix3d::Constant(kUndefined);
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Constant(kUndefined);
};

// What became of a frame's measurement of a landmark.
enum class Measured { kNot, kAccepted, kRejected };

constexpr std::string_view to_string(Measured measured) {
  constexpr std::string_view kNames[] = {"-", "accepted", "rejected"};
  return kNames[static_cast<std::size_t>(measured)];
}

// Where a landmark was expected in the image before the frame's measurements were used. Of the
// other cameras of a rig only where they measured it.
struct Prediction {
  int track = 0;
  Eigen::Vector2d pixel;
  // Of the innovation, the noise of the measurement included (of Belief::predict_pixels() not yet)
  // [px^2].
  Eigen::Matrix2d S;
  Measured measured = Measured::kNot;
  int camera = 0;
};

// What happened in one frame.
struct FrameReport {
  int accepted = 0;         // measurements of landmarks in the state that passed the gate
  int accepted_static = 0;  // of them those of landmarks at rest, labelled or held
  int rejected = 0;         // those that did not
  int out_of_view = 0;      // measured, but predicted behind the camera or far outside the image
  int admitted = 0;         // landmarks initialised
  std::vector<LandmarkEstimate> retired;  // the last word on each landmark removed
  double nis_sum = 0.0;    // sum over the accepted of their 2-dof normalised innovation squared
  double joint_nis = 0.0;  // nu' S^-1 nu of all accepted together, of 2 dof each; NaN: not stated
  // Sums of thirty innovations of a track that ended here, and their NIS added up, of 2 dof each
  // (modules/lasting_errors.h).
  int lasting_sums = 0;
  double lasting_nis = 0.0;
  int state_size = 0;  // dimension of the error state after the frame
  // Of the log of the world's scale, as the estimator holds it: where nothing metric enters, never
  // more than was stated. NaN: not stated, as of a filter or with landmarks known beforehand.
  double scale_information = kUndefined;
  // Log of the factor by which the frame has changed the size of the world (scale_change.h). NaN:
  // the scale is known, or it is not stated.
  double scale_change = kUndefined;
  int negative_inverse_depth = 0;  // landmarks believed behind infinity (legal, counted)
  // By track and camera; where asked for (Estimator::keep_predictions).
  std::vector<Prediction> predictions;
};

// The estimate is no longer a number, or its covariance no longer a covariance. The run ends, is
// counted as diverged, and keeps what was computed before.
struct Diverged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Told when a stage of a frame begins; a stage ends when the next one begins or the frame ends.
class StageListener {
 public:
  // What is noted for pictures (keep_predictions()) is no part of the estimator's time.
  static constexpr std::string_view kPredictions = "predictions";

  virtual ~StageListener() = default;
  virtual void begin(std::string_view stage) = 0;
};

// For who does not time.
class NoStages final : public StageListener {
 public:
  void begin(std::string_view) override {}
};

class Estimator {
 public:
  virtual ~Estimator() = default;

  // From now on reports hold the predictions of what the gate has judged and of every other
  // landmark predicted in the image, where the estimator has any. Costs time and changes no
  // estimate.
  virtual void keep_predictions() {}

  // Takes the next frame. Throws Diverged, or std::invalid_argument when its time does not
  // increase.
  virtual FrameReport process(const Frame& frame, StageListener& stages) = 0;

  // The newest camera: the filtered estimate, for the smoother too.
  virtual CameraEstimate camera() const = 0;

  // The pose `frames` (at least 1) before the newest; none where the estimator no longer keeps it.
  virtual std::optional<PoseEstimate> pose_before(int /*frames*/) const { return std::nullopt; }

  // Every landmark that is in the state now.
  virtual std::vector<LandmarkEstimate> landmarks() const = 0;

  // Those of them whose newest measurement is of frame `index`: cheaper where covariances cost.
  virtual std::vector<LandmarkEstimate> landmarks_measured(int index) const {
    std::vector<LandmarkEstimate> measured;
    for (LandmarkEstimate& l : landmarks()) {
      if (l.last_frame == index) measured.push_back(std::move(l));
    }
    return measured;
  }

  // Each mechanism beyond the thesis, and whether it acts in this run; see in_force.h. Empty of an
  // estimator that states none. Grows more certain with each frame: counts are of the frames so
  // far.
  virtual InForce in_force() const { return {}; }

  // Every camera so far as later frames have corrected it, oldest first; empty for a pure filter.
  // Called once, after the last frame: a batch solves here.
  virtual std::vector<CameraEstimate> smoothed(StageListener& /*stages*/) { return {}; }
};

}  // namespace slammot
