// All that is drawn of a frame.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "estimation/estimator.h"

namespace slammot {

// By track.
template <typename Row>
const Row* find_track(const std::vector<Row>& rows, int track) {
  const auto found = std::ranges::lower_bound(rows, track, {}, &Row::track);
  return found != rows.end() && found->track == track ? &*found : nullptr;
}

// Of one camera of the rig, by track.
struct CameraView {
  std::vector<Prediction> predictions;  // may be none
  std::vector<Observation> observations;
};

struct PictureState {
  CameraEstimate estimate;
  std::vector<LandmarkEstimate> landmarks;  // all in the state after the frame, by track
  std::vector<CameraView> views = std::vector<CameraView>(1);
  std::span<const Eigen::Vector3d> path = {}, truth = {};  // W, up to the frame; may be empty

  bool is_measured(int track) const {
    return std::ranges::any_of(
        views, [&](const CameraView& view) { return find_track(view.observations, track); });
  }
};

}  // namespace slammot
