// What the runs of a cell say together at every frame.
//
// The NEES of the camera has one sample a run: its mean over N runs is compared with the chi-square
// interval of N runs. Landmarks of one run share its camera's error: the interval of their mean
// NEES comes from resampling the runs, lies around that mean, and should contain 3.
#pragma once

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "eval/metrics/pose_pairs.h"
#include "eval/statistics/bootstrap.h"

namespace slammot {

// Per frame: errors, NEES (after the first frame, whose covariance is a pin) and the standard
// deviations that the estimator states, the roots of the traces.
nlohmann::ordered_json frames_json(const std::vector<PosePair>& pairs);

// The same of a run that is judged by the truth of `sequence`. Where that is measured, position
// errors are after similarity alignment and there is neither NEES nor standard deviation. A part
// without any covariance has no NEES either.
nlohmann::ordered_json judged_frames(const Sequence& sequence, const std::vector<PosePair>& pairs);

class FrameStatistics {
 public:
  // `frames` or `smoothed_frames` of one run (docs/formats.md); without NEES where truth is
  // measured.
  void add(const nlohmann::ordered_json& frames);

  bool empty() const { return frames_.empty(); }

  // Arrays over the frames.
  nlohmann::ordered_json per_frame() const;

  // Of each part: mean, of the camera's over all poses of all runs with its 95% bootstrap interval
  // over runs, of landmarks over the frames; largest of a frame, share of frames `inside`, of those
  // that have an interval.
  nlohmann::ordered_json anees() const;

 private:
  struct Frame {
    std::map<std::string, std::vector<double>> samples;        // one a run
    std::map<std::string, std::vector<RunSum>> landmark_nees;  // by part
  };
  struct Anees {
    std::string part;
    int dof = 0;
    std::vector<double> value, lower, upper;  // by frame
    std::vector<double> inside;               // 1 or 0; undefined without an interval
  };

  std::vector<Anees> parts() const;
  Anees camera_part(const std::string& part, int dof) const;
  Anees landmark_part(const std::string& part) const;

  std::map<int, Frame> frames_;                          // by Frame::index
  std::map<std::string, std::vector<RunSum>> run_sums_;  // of the camera's NEES, by part
};

}  // namespace slammot
