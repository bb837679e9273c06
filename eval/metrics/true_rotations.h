// Rotations that nobody recorded: all of them equal, as in a file of positions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "eval/metrics/pose_pairs.h"

namespace slammot {

// What the two rotations of the pairs say together where only one of them ever turns.
struct EqualRotations {
  bool not_judged = false;  // no error of a rotation is known
  std::string reason;       // with the angle that the other one spans
};

// Nothing where both turn, where neither does, or where the position has failed too: an estimator
// that is lost beside a camera that never turns has an error. `trusted`: a truth that was simulated
// for the run may well never turn, and is judged by.
std::optional<EqualRotations> equal_rotations(const std::vector<PosePair>& pairs,
                                              bool after_alignment, bool trusted);

}  // namespace slammot
