// The pictures of a stored run, as a film and, of single frames, for a paper.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "datasets/sequence/sequence.h"

namespace slammot {

// Writes a film to `output`, see frontend/rendering/film.h, and returns of how many pictures.
// Throws InputError as RunPictures does, or if an image cannot be used. A run without
// predictions.csv is drawn without ellipses, with a note on stderr.
int draw_run(const std::filesystem::path& run, const Sequence& sequence,
             const std::filesystem::path& output,
             const std::function<void(int done, int total)>& progress);

// Writes frame_NNNNNN.json and .pdf to `output` of the frames with these numbers, and prints the
// names of the PDFs. Returns the program's exit code; what is wrong has been said.
int draw_figures(const std::filesystem::path& run, const Sequence& sequence,
                 const std::filesystem::path& output, const std::vector<int>& frames);

}  // namespace slammot
