// The truth in the coordinates of the estimators, for Jacobians that are taken there.
#pragma once

#include <optional>

#include "models/landmarks/landmark_models.h"
#include "models/truth.h"

namespace slammot {

// Throws std::invalid_argument when the frame has none.
const CameraState& true_camera(const Truth& truth, int frame);

// (y, w) at a constant velocity as the landmark model has it, seen from `anchor` (W); nothing where
// it is not known.
std::optional<LandmarkVector> true_state(const Truth& truth, const LandmarkFunctions& functions,
                                         int track, int frame, const Eigen::Vector3d& anchor);

}  // namespace slammot
