// TUM RGB-D: `rgb.txt` (timestamp, file) and `groundtruth.txt` (timestamp tx ty tz qx qy qz qw).
//
// Its poses are of the colour camera's optical frame, as ours. No calibration lies in the folder: a
// sequence that names freiburg1, 2 or 3 in its head has the colour camera that the benchmark's page
// gives for it, with its lens. For others the page's default is taken, 525 px without a lens, which
// it recommends for depth images. `track --camera` overrides all. `depth.txt` lists depth images as
// seen by the colour camera, of 16 bits, 5000 to a metre.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

bool is_tum_rgbd(const std::filesystem::path& folder);
Sequence read_tum_rgbd(const std::filesystem::path& folder);
void add_tum_depth(Sequence& sequence);

}  // namespace slammot
