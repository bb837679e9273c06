// Sequences of images by their layout, recognised by content: what there is before the front end
// has measured anything. One row adds a layout.
//
// Only the list is read, never an image, so that a folder of 100,000 images costs their names.
#pragma once

#include <span>
#include <string_view>

#include "datasets/sequence/sequence.h"

namespace slammot {

struct ImageReaderRow {
  std::string_view name;
  std::string_view description;  // what it is recognised by
  bool (*recognises)(const std::filesystem::path& folder);
  Sequence (*read)(const std::filesystem::path& folder);
  void (*add_others)(Sequence& sequence) = nullptr;  // where the layout may have more than that
};
std::span<const ImageReaderRow> image_reader_table();

// The row that recognises the folder, or nothing.
const ImageReaderRow* find_image_reader(const std::filesystem::path& folder);

// Frames without observations, an image for each (relative to the folder), the camera (width and
// height 0 where only the images themselves tell), and the truth, with the pose of *this* camera in
// the project's convention. Throws InputError if no row recognises the folder, if it cannot be
// listed, or for a line that is refused.
Sequence read_images(const std::filesystem::path& folder);

// Adds what lies beside them: a second camera with its images, or depth images. Nothing where the
// layout has none. Throws InputError.
void add_other_images(Sequence& sequence);

// Whether the file of each image exists, in the order of the frames: asked before the first image
// is decoded, so that a missing frame is not found after an hour.
std::vector<bool> images_present(const Sequence& sequence);

}  // namespace slammot
