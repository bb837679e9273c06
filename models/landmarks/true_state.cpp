#include "models/landmarks/true_state.h"

#include <stdexcept>

#include "models/inverse_depth.h"

namespace slammot {

const CameraState& true_camera(const Truth& truth, int frame) {
  const auto camera = truth.cameras.find(frame);
  if (camera == truth.cameras.end()) {
    throw std::invalid_argument("linearisation ideal needs a true camera for every frame");
  }
  return camera->second;
}

std::optional<Vector6d> true_state(const Truth& truth, const LandmarkFunctions& functions,
                                   int track, int frame, const Eigen::Vector3d& anchor) {
  const auto landmark = truth.landmarks.find(track);
  if (landmark == truth.landmarks.end()) return std::nullopt;
  const TruePoint* point = landmark->second.at(frame);
  if (point == nullptr) return std::nullopt;
  Vector6d x;
  x << inverse_depth_of(Eigen::Vector3d(point->position - anchor)), Eigen::Vector3d::Zero();
  x.tail<3>() = functions.motion_of(x.head<3>(), point->velocity);
  return x;
}

}  // namespace slammot
