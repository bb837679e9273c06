// The rotation of an estimate, checked against five-point estimates from the same tracks.
//
// An angle between the two says little: before a plane, or with a short baseline, the five-point
// rotation is degrees off and explains the tracks as well. So the estimate's rotation is tried on
// the tracks: of how many does it explain the epipolar geometry, with the translation that suits it
// best, where the five-point estimate explains so many? Nothing of this depends on a scale.
#pragma once

#include "datasets/sequence/sequence.h"
#include "estimation/estimator.h"
#include "estimation/rotation_span.h"

namespace slammot {

// `cameras`: after each of the first frames of the sequence. A span begins at every fifth frame and
// is at most ten frames long, less where tracks are short.
std::vector<RotationSpan> check_rotation(const Sequence& sequence,
                                         const std::vector<CameraEstimate>& cameras,
                                         double pixel_sigma);

}  // namespace slammot
