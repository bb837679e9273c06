// How exact the tracks are, measured from the tracks themselves.
//
// Between two frames half a typical track apart, points at rest lie on epipolar lines. A
// fundamental matrix is found by least median of squares, which bears up to half of the points
// moving, and then fitted (8-point) to the points within 3 sigma of it, five times. The Sampson
// distance d is to first order the error of one pixel coordinate; sigma is taken from the distance
// that holds three quarters of the points, q75(|d|) / 1.150, with 7 degrees of freedom taken off:
// the median would tell of the better half only, for tracks have a tail of patches that lie on two
// depths, and beyond three quarters moving points may stand. The median over the pairs of frames is
// the answer. It holds what changes between the two frames, drift included, and what the lens model
// leaves; errors along the epipolar line are not seen.
#pragma once

#include <optional>

#include "datasets/sequence/sequence.h"

namespace slammot {

struct TrackNoise {
  double sigma = 0.0;  // of each pixel coordinate [px]
  int lag = 0;         // frames between the two of a pair
  int pairs = 0;       // of frames
};

// What is stated at least [px]: the distances hold neither what of a track lasts for many frames
// nor the tail of bad tracks. By the NEES of the rendered room, whose pixels have 0.045 px
// (docs/recordings.md, also on what it costs).
inline constexpr double kLeastStated = 0.1;

// Nothing if no two frames share enough tracks.
std::optional<TrackNoise> measure_noise(const Sequence& sequence);

}  // namespace slammot
