// The scenarios whose measurements come from pixels: a scene is rendered and tracked in memory.
#pragma once

#include <span>

#include "datasets/simulation/scenario.h"

namespace slammot {

// `room` and `basement` (room.h). The sequence that `slammot simulate --render` and `slammot track`
// would make of its images, with the truth of every track, and no images. A sequence takes up
// to minutes: the latest are kept, for the other estimators that a study gives the same seed.
std::span<const ScenarioRow> rendered_scenarios();

}  // namespace slammot
