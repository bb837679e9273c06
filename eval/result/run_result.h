// What one run of one estimator over one sequence leaves behind. Plain data: produced by run.h or
// read back by run_reader.h, judged by metrics/, written by run_writer.h.
//
// A covariance that is not known is NaN, as in models/estimator.h.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estimation/estimator.h"

namespace slammot {

struct StageTime {
  int frame = 0;
  std::string stage;  // `total` is the whole frame
  double milliseconds = 0.0;
  int state_size = 0;
};

// What happened in a frame, or the sums over frames (state_size: the largest).
struct FrameCounts {
  int accepted = 0;
  int accepted_static = 0;  // of static landmarks
  int rejected = 0;
  int out_of_view = 0;
  int admitted = 0;
  int pruned = 0;
  int negative_inverse_depth = 0;
  int state_size = 0;
  double nis_sum = 0.0;    // over the accepted, each on its own
  double joint_nis = 0.0;  // of the accepted of a frame together
  int lasting_sums = 0;    // FrameReport has these two
  double lasting_nis = 0.0;
};

// FrameReport::scale_information over a run: after its first frame, where only statements tell the
// scale, the largest, and after its last.
struct ScaleInformation {
  double stated = kUndefined;
  double largest = kUndefined;
  double last = kUndefined;
};

struct LandmarkRecord {
  int frame = 0;  // the estimate is that after this frame
  LandmarkEstimate estimate;
};

struct PredictionRecord {
  int frame = 0;
  Prediction prediction;
};

// A landmark that had to be classified: neither known beforehand nor labelled by rule.
struct ClassificationRecord {
  int track = 0;
  std::optional<Label> truth;  // when it was last measured, see label_truth.h
  Label label = Label::kUnknown;
  std::optional<int> decision_frame;
  int observations = 0;  // used up to the decision, or in all where there is none
};

// One landmark in a frame in which it was measured, for error over observed frames (thesis
// figure 4.2).
struct LandmarkSample {
  int track = 0;
  int frame = 0;
  int observations = 0;
  Label label = Label::kUnknown;       // that it had
  Label truth = Label::kStatic;        // its class
  Label motion = Label::kStatic;       // what it was in this frame
  double position_error = kUndefined;  // [m]
  double velocity_error = kUndefined;  // [m/s]
  double position_nees = kUndefined;   // 3
  double velocity_nees = kUndefined;   // 3
};

struct Divergence {
  int frame = 0;
  std::string reason;
};

// At which error and NEES are reported, in frames: up to the oldest of 5, 10, 20 and 40.
inline constexpr int kLags[] = {1, 2, 4, 9, 19, 39};

// What a run says against itself (self_check.h).
struct RunWarning {
  std::optional<int> frame;  // where it begins; none of a whole run
  std::string reason;
};

// How `--align` has brought a run to the truth (trajectory/align_run.h): r_true is about
// scale rotation r_estimated + translation.
struct RunAlignment {
  std::string by;
  int poses = 0;
  int fitted = 0;        // degrees of freedom of the alignment
  bool verdict = false;  // whether NEES still tells a consistent estimator from others
  std::string note;      // that in words
  double scale = 1.0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

struct RunResult {
  int frames_offered = 0;
  std::vector<int> frames;                // index of each frame done
  std::vector<CameraEstimate> filtered;   // after each of them
  std::vector<FrameCounts> counts;        // likewise; empty when read back
  std::vector<double> ray_spread;         // likewise, see run/ray_spread.h
  std::vector<double> scale_information;  // likewise
  std::vector<double> scale_changes;      // likewise
  std::vector<CameraEstimate> smoothed;   // empty for a pure filter
  // The shape of `filtered` in the scale of its end (trajectory/last_scale.h); empty where the
  // scale is known or no estimator says how it changed.
  std::vector<CameraEstimate> last_scale;
  // A batch is solved once, after the last frame: its result is `smoothed`, and `filtered` is that
  // of the window in front of it.
  bool batch = false;
  // By lag in frames: the camera so many frames ago, after each frame; velocities are not known.
  std::map<int, std::vector<CameraEstimate>> lagged;
  std::vector<LandmarkRecord> landmarks;      // every track's newest landmark, see LandmarkHistory
  std::vector<LandmarkRecord> every_frame;    // all of every frame, where asked for
  std::vector<PredictionRecord> predictions;  // likewise, by frame and track
  std::vector<ClassificationRecord> classification;
  std::vector<LandmarkSample> samples;
  std::vector<StageTime> timing;
  double smoothing_ms = 0.0;  // after the last frame
  FrameCounts totals;
  ScaleInformation scale;
  std::optional<Divergence> diverged;
  std::vector<RunWarning> warnings;
  std::optional<InForce> in_force;  // empty: the estimator states none; unset: made elsewhere
  std::optional<RunAlignment> alignment;

  // What the run is judged by.
  const std::vector<CameraEstimate>& judged() const { return batch ? smoothed : filtered; }
};

}  // namespace slammot
