// What a run says against itself, without any truth: an estimator that is lost often leaves
// numbers that are finite and wrong, and a covariance that is small.
#pragma once

#include <optional>
#include <span>

#include "estimation/rotation_span.h"
#include "eval/result/run_result.h"
#include "eval/run/scale_check.h"

namespace slammot {

// In the order of their first frame; empty when nothing speaks against the run. `rotations`: empty
// where nobody compared them. `scale`: none where nobody is asked of it.
std::vector<RunWarning> self_check(const RunResult& run,
                                   std::span<const RotationSpan> rotations = {},
                                   const std::optional<StatedScale>& scale = {});

// Covariances of the pose that are not positive definite, the first pose left out.
std::optional<RunWarning> covariance_warning(const RunResult& run);

}  // namespace slammot
