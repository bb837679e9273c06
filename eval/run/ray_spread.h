// How much the landmarks in view say about the camera: rays that lie in one plane through it, as
// those to points of one line do, leave a turn about that line unseen.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

// Root mean square distance in the image, in pixel_sigma, of the static landmarks used in `frame`
// from the line that fits them best. NaN where there are none, or not all can be unprojected.
double ray_spread(const Sequence& sequence, const Frame& frame,
                  const std::vector<LandmarkEstimate>& measured);

}  // namespace slammot
