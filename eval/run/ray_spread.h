// How far the landmarks in use are from one line of the image. Points of one line in space lie on
// one, and leave a turn about it unseen. The converse need not hold: points of a plane through the
// camera, at different depths, determine the turn.
#pragma once

#include "datasets/sequence/sequence.h"
#include "estimation/estimator.h"

namespace slammot {

// Of the pixels of the static landmarks used in `frame`: root mean square distance to the image of
// the plane through the camera that fits their rays best, each in its own sigma; through the lens,
// to first order. NaN where there are none, or not all can be unprojected.
double ray_spread(const Camera& camera, double pixel_sigma, const Frame& frame,
                  const std::vector<LandmarkEstimate>& measured);

}  // namespace slammot
