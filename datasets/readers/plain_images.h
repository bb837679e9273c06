// A folder of nothing but images, which states neither times nor camera.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

// Whether images lie in the folder itself, by the endings of their names.
bool has_plain_images(const std::filesystem::path& folder);

// In the order of their names, numbers in them by value (2 before 10), at a rate [Hz] from time 0
// on. The camera is not stated: width and height are 0. Throws InputError where there is none.
Sequence read_plain_images(const std::filesystem::path& folder, double rate);

// Where the last numbers in the names do not go up by the same step throughout, so that frames are
// missing or two cameras mixed: that.
std::optional<std::string> numbering_fault(const std::vector<std::string>& images);

}  // namespace slammot
