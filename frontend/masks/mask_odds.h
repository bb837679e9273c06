// Odds of rest from somebody else's masks, an image for each frame: grey 0 is what rests, 255 what
// moves, and between them is the probability that it moves.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "datasets/sequence/sequence.h"

namespace slammot {

// The mask of each frame of `images`, as read_images() gives them: named as its image but for the
// ending; where no mask is named so, in their order. Throws InputError where one is missing.
std::vector<std::filesystem::path> find_masks(const std::filesystem::path& folder,
                                              const Sequence& images);

struct MaskOdds {
  std::map<int, double> p_static;     // of all tracks
  std::vector<std::string> warnings;  // of what may be wrong with the masks, one line each
};

// `masks` as find_masks() gives them; `tracked`: the same images, perhaps not all, with their
// measurements. Throws InputError for a mask that is no image of their size.
MaskOdds odds_by_masks(const std::vector<std::filesystem::path>& masks, const Sequence& images,
                       const Sequence& tracked);

}  // namespace slammot
