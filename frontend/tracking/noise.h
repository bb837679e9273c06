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

// kCommon: one sigma for all measurements. kAlignment: each has its own,
//   kLasting * sqrt(a^2 + (kMismatch s)^2)
// with s by the alignment of its patch (patch.h), and a of the images, the same for all. Then the
// tail is that of s, and a is taken from the median instead. The matrix is fitted without weights,
// so that a is too large where many patches fit badly.
enum class NoiseModel { kCommon, kAlignment };

struct TrackNoise {
  double sigma = 0.0;               // of each pixel coordinate; kAlignment: a [px]
  int lag = 0;                      // frames between the two of a pair
  int pairs = 0;                    // of frames
  double lower = 0.0, upper = 0.0;  // quartiles over the pairs [px]: movers spread them
};

// What is stated at least [px]: the distances hold neither what of a track lasts for many frames
// nor the tail of bad tracks. By the NEES of the rendered room, whose pixels have 0.045 px
// (docs/recordings.md).
inline constexpr double kLeastStated = 0.1;

// What a patch meets in a later image is another view of it, not the same with noise: over pairs of
// frames errors grow by 1.1 to 1.3 times s on three recordings, by 3.3 on one.
// Where a track begins s is that of 2 grey levels of noise, for want of a residual.
inline constexpr double kMismatch = 1.5;
// A track's error lasts for many frames, and the estimators take it for new in each: by the NEES of
// the rendered room.
inline constexpr double kLasting = 1.75;

// Nothing if no two frames share enough tracks. The measurements as the tracker gives them.
std::optional<TrackNoise> measure_noise(const Sequence& sequence,
                                        NoiseModel model = NoiseModel::kCommon);

// From the measurements as the tracker gives them to what is stated of them: `pixel_sigma`, and how
// each differs from it. kAlignment needs a noise that could be measured, else it is kCommon.
void state_noise(const std::optional<TrackNoise>& noise, NoiseModel model, Sequence& sequence);

}  // namespace slammot
