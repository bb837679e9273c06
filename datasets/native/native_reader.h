// Reads the native sequence folder: sequence.yaml, frames.csv, observations.csv and what is
// optional.
//
// Positions in metres in W, T_WC as Hamilton quaternion x y z w, pixels, seconds. The velocities of
// the truth are not in the files and come from central differences.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

// Throws InputError for everything it refuses.
Sequence read_native(const std::filesystem::path& folder);

// The same before the front end has measured: frames with their images, camera, statements and
// truth. What refers to tracks is not read.
Sequence read_native_images(const std::filesystem::path& folder);

// The images of the other cameras of a rig, where the folder names them.
void add_native_others(Sequence& sequence);

// Whether the folder means to be one, right or wrong inside.
bool is_native(const std::filesystem::path& folder);

}  // namespace slammot
