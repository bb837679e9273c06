#include "models/landmarks/true_state.h"

#include <stdexcept>

namespace slammot {

const CameraState& true_camera(const Truth& truth, int frame) {
  const auto camera = truth.cameras.find(frame);
  if (camera == truth.cameras.end()) {
    throw std::invalid_argument("linearisation ideal needs a true camera for every frame");
  }
  return camera->second;
}

std::optional<LandmarkVector> true_state(const Truth& truth, const LandmarkFunctions& functions,
                                         int track, int frame, const Eigen::Vector3d& anchor) {
  const auto landmark = truth.landmarks.find(track);
  if (landmark == truth.landmarks.end()) return std::nullopt;
  const TruePoint* point = landmark->second.at(frame);
  if (point == nullptr) return std::nullopt;
  const Eigen::Vector3d y = point_at(functions.point, point->position - anchor);
  return landmark_state(y, functions.motion_of(y, point->velocity));
}

}  // namespace slammot
