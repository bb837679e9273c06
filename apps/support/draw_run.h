// The pictures of a stored run whose landmarks.csv has every frame, over the images of its
// sequence.
#pragma once

#include <filesystem>
#include <functional>

#include "datasets/sequence/sequence.h"

namespace slammot {

// Writes them to `output`, see frontend/film.h, and returns how many. Throws InputError if the
// sequence names no images or one of them cannot be used, or if the run has not the landmarks of
// every frame.
int draw_run(const std::filesystem::path& run, const Sequence& sequence,
             const std::filesystem::path& output,
             const std::function<void(int done, int total)>& progress);

}  // namespace slammot
