// What of a sequence can be read and is hardly meant: a sentence for each. None speaks of a
// sequence whose times are seconds, whose truth is complete and whose images differ.
#pragma once

#include "datasets/sequence/true_poses.h"

namespace slammot {

using Hints = std::vector<std::string>;

// Of the recorded poses beside the frames: few frames have a truth, or a row jumps away and back.
// Throws InputError of a row that is so far off that nothing moves there.
Hints truth_hints(const std::filesystem::path& file, const std::vector<TimedPose>& poses,
                  const Sequence& sequence);

// Of the frames: their step, measurements that repeat, and what is stated of the first camera
// beside an exact truth of it.
Hints frame_hints(const Sequence& sequence);

// `; are these nanoseconds ..?` where times of another unit would lie among those of the frames;
// else empty. `first`, `last`: [s], as read.
std::string unit_clue(double first, double last, const std::vector<Frame>& frames);

// Where half of the tracks with odds from outside are measured in no frame: they may be those of
// another tracking.
std::optional<std::string> prior_hint(const Sequence& sequence);

// Measurements that no ray of the lens explains are taken out; what that leaves out, if any.
std::optional<std::string> leave_out_rayless(Sequence& sequence);

}  // namespace slammot
