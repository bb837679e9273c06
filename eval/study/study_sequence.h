// The measurements of one run of a study: simulated, or recorded.
#pragma once

#include "datasets/sequence/sequence.h"
#include "eval/study/study.h"

namespace slammot {

// Of a recorded sequence the seed draws the noise of `noise` pixels that is added to its
// measurements and to the noise that it states. Throws std::invalid_argument for parameters that
// are none, InputError for a sequence that cannot be judged.
Sequence study_sequence(const StudyCell& cell, std::uint64_t seed);

// Of a recorded sequence: that no noise is added.
bool is_single_run(const StudyCell& cell);

}  // namespace slammot
