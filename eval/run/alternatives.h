// What else a file of poses or covariances may hold: where its errors are absurd as it is read, a
// few named alternatives are tried, and a sentence says which would fit. None is ever taken.
#pragma once

#include "eval/metrics/pose_pairs.h"
#include "eval/trajectory/error_convention.h"

namespace slammot {

// Other orders of the quaternion, inverted poses, and poses of another body or in another world.
// Of measured truth, whose world is nobody's, what remains after similarity alignment is compared.
std::optional<std::string> other_poses(const std::vector<PosePair>& pairs, bool exact_truth);

// Other conventions, orders and units of the covariance. `as_written`: pairs whose covariances are
// as their file has them, which was said to be in `stated`.
std::optional<std::string> other_covariances(const std::vector<PosePair>& as_written,
                                             const ErrorConvention& stated);

}  // namespace slammot
