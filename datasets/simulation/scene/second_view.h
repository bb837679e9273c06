// What a simulated rig measures besides: the pixels of a second camera to the right of the first,
// with the same lens and noise, and depths at each point's first pixel. From a sequence with its
// exact truth; streams of their own, so that camera 0 measures the same with and without.
#pragma once

#include "datasets/simulation/scene/recording.h"

namespace slammot {

MountedCamera camera_to_the_right(const Camera& first, double baseline);  // [m]

void add_second_view(const RecordingOptions& options, std::uint64_t seed, Sequence& sequence);
void add_depths(const RecordingOptions& options, std::uint64_t seed, Sequence& sequence);

}  // namespace slammot
