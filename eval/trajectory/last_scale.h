// The shape of a filtered path, all of it in the scale that is believed at its end.
//
// As filtered, pose j is in the scale of frame j, which later frames change by factors e^t
// (estimation/modules/scale_change.h), each about the first position o:
//
//   r_j := o + exp(sum_{k > j} t_k) (r_j - o)
//
// Poses are brought to another scale, not steps: the two ends of a step as filtered are in two.
#pragma once

#include <span>
#include <vector>

#include "estimation/estimator.h"

namespace slammot {

// `changes`: t_k of each pose's frame. Nothing where one is not known. Covariances are not stated.
std::vector<CameraEstimate> in_last_scale(std::vector<CameraEstimate> path,
                                          std::span<const double> changes);

}  // namespace slammot
