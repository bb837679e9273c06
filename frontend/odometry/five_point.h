// Visual odometry of pairs of images, the baseline of real recordings: five-point relative poses
// (two_view.h) between each image and the last key frame. No motion model, no landmark filter, no
// covariance: NaN.
//
// An image becomes a key frame once the median parallax is large, or few tracks are left. Points
// are triangulated between key frames, and the length of a step is the one at which they are seen
// along their rays (weighted median). The first length is that of the stated first velocity, or of
// known landmarks; with neither, that of 1 m/s. A plane has two relative poses of the same cost, so
// that before one (desk_hand) single frames are degrees off.
#pragma once

#include <memory>

#include "estimation/estimator.h"

namespace slammot {

std::unique_ptr<Estimator> make_five_point(const Setup& setup);

}  // namespace slammot
