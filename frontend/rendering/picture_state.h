// All that is drawn of a frame.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "estimation/estimator.h"

namespace slammot {

struct PictureState {
  CameraEstimate estimate;
  std::vector<LandmarkEstimate> landmarks;  // all in the state after the frame, by track
  std::vector<Prediction> predictions;      // by track; may be none
  std::vector<Observation> observations;    // by track
  std::span<const Eigen::Vector3d> path = {}, truth = {};  // W, up to the frame; may be empty

  const LandmarkEstimate* landmark(int track) const {
    return find(landmarks, track, &LandmarkEstimate::track);
  }
  const Prediction* prediction(int track) const {
    return find(predictions, track, &Prediction::track);
  }
  bool is_measured(int track) const { return find(observations, track, &Observation::track); }

 private:
  template <typename Row>
  static const Row* find(const std::vector<Row>& rows, int track, int Row::*key) {
    const auto found = std::ranges::lower_bound(rows, track, {}, key);
    return found != rows.end() && (*found).*key == track ? &*found : nullptr;
  }
};

}  // namespace slammot
