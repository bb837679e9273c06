// `--align`: a run brought into the frame (and scale) of the truth before errors and NEES, with its
// velocities, landmarks and covariances: with e = [dr (W), dtheta (C, right)] dr turns and scales
// with the world, dtheta is the camera's and stays.
//
// A fit uses the truth: what is left of the errors of n poses has 6 or 7 of 6 n degrees of freedom
// less, and nothing of what all poses have in common; rotations get what the fit of positions errs.
// NEES is then too small or too large, also of a consistent estimator, and decides nothing.
#pragma once

#include <map>
#include <string>

#include "datasets/sequence/sequence.h"
#include "eval/result/run_result.h"

namespace slammot {

enum class AlignBy { kNone, kFirst, kSE3, kSim3 };
inline const std::map<std::string, AlignBy> kAlignments = {{"none", AlignBy::kNone},
                                                           {"first", AlignBy::kFirst},
                                                           {"se3", AlignBy::kSE3},
                                                           {"sim3", AlignBy::kSim3}};

// One similarity for all of a run, from the poses that it is judged by. Throws
// std::invalid_argument where these do not determine it.
void align_run(const Sequence& sequence, AlignBy by, RunResult& run);

}  // namespace slammot
