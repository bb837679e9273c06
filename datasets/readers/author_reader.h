// The text format of the thesis author's published program: groundTruth.txt starting
// `numOfFrames:`.
//
// Its camera has x left, y up, z forward: R_ours = R diag(-1, -1, 1), positions as they are; f =
// 170, c = (160, 120), 320x240, 30 Hz. What the program assumes is stated as its author did: 2 px,
// 6 m/s^2 and 6 rad/s^2, points 9 to 12 of the first frame known. Points are tracks; velocities of
// moving points are central differences. Its pixels carry a bias per point, so the truth is not
// exact.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

// Throws InputError for everything it refuses.
Sequence read_author(const std::filesystem::path& folder);

bool is_author(const std::filesystem::path& folder);

}  // namespace slammot
