// How far the landmarks in use are from one line of the image. Points of one line in space lie on
// one, and leave a turn about it unseen. The converse need not hold: points of a plane through the
// camera, at different depths, determine the turn.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

// Of the rays to the static landmarks used in `frame`: root mean square angle to the plane through
// the camera that fits them best, times fx, in the sequence's pixel_sigma; near the optical axis
// the distance in the image. NaN where there are none, or not all can be unprojected.
double ray_spread(const Sequence& sequence, const Frame& frame,
                  const std::vector<LandmarkEstimate>& measured);

}  // namespace slammot
