// The errors and the NEES of one run in every frame, as results.jsonl and compare.json have them.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "eval/metrics/pose_pairs.h"

namespace slammot {

// Per frame after the first, whose covariance is a pin: errors, NEES and the standard deviation of
// the position that the estimator states, the root of the trace; judged by the truth of `sequence`.
// Where that is measured, position errors are after similarity alignment and there is neither NEES
// nor standard deviation. A part without any covariance has no NEES either.
nlohmann::ordered_json judged_frames(const Sequence& sequence, const std::vector<PosePair>& pairs);

}  // namespace slammot
