// TUM RGB-D: `rgb.txt` (timestamp, file) and `groundtruth.txt` (timestamp tx ty tz qx qy qz qw).
//
// Its poses are of the colour camera's optical frame, as ours. No calibration lies in the folder: a
// sequence that names freiburg3 in its head is rectified with its own calibration; for the others
// the benchmark's authors recommend 525 px without undistortion, which is taken. `track --camera`
// overrides both.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

bool is_tum_rgbd(const std::filesystem::path& folder);
Sequence read_tum_rgbd(const std::filesystem::path& folder);

}  // namespace slammot
