// From recorded poses to the true camera at each frame.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

struct TimedPose {
  double timestamp;                // [s]
  Eigen::Vector3d position;        // W [m]
  Eigen::Quaterniond orientation;  // R_WC
  int line = 0;                    // of its file; 0 where that has none
};

// [s]; infinite of fewer than two frames.
double median_interval(const std::vector<Frame>& frames);

// The longest time between two poses that is interpolated over, in median intervals of the frames.
inline constexpr double kLongestGap = 1.5;

// The pose at the time of each frame. One within a microsecond is taken as it is. Else it lies
// between the two around it, in position on a line and in rotation along the shortest turn, where
// these are at most kLongestGap apart; beside a longer gap, and at either end, a pose within half a
// millisecond, as rounded times have, is taken. Nothing elsewhere. With velocities from
// difference_velocities(). `poses` in increasing time.
std::vector<std::optional<CameraState>> true_cameras(const std::vector<TimedPose>& poses,
                                                     const std::vector<Frame>& frames);

// Velocity (W) and angular velocity (C) by differences of the neighbouring poses, central where
// there are two, zero where there is none.
void difference_velocities(const std::vector<Frame>& frames,
                           std::vector<std::optional<CameraState>>& truth);

}  // namespace slammot
