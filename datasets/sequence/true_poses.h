// From recorded poses to the true camera at each frame.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

struct TimedPose {
  double timestamp;                // [s]
  Eigen::Vector3d position;        // W [m]
  Eigen::Quaterniond orientation;  // R_WC
};

// The pose nearest in time to each frame, nothing when it is further than half a (median) frame;
// with velocities from difference_velocities(). `poses` in increasing time.
std::vector<std::optional<CameraState>> match_truth(const std::vector<TimedPose>& poses,
                                                    const std::vector<Frame>& frames);

// The pose at the time of each frame, between the two recorded around it (linear, and along the
// shortest turn), for truth that is denser than the frames; nothing where these are further apart
// than a (median) frame. `poses` in increasing time.
std::vector<std::optional<CameraState>> interpolate_truth(const std::vector<TimedPose>& poses,
                                                          const std::vector<Frame>& frames);

// Velocity (W) and angular velocity (C) by differences of the neighbouring poses, central where
// there are two, zero where there is none.
void difference_velocities(const std::vector<Frame>& frames,
                           std::vector<std::optional<CameraState>>& truth);

}  // namespace slammot
