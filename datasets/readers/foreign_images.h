// What the readers of foreign image layouts share.
#pragma once

#include "datasets/sequence/sequence.h"
#include "datasets/sequence/true_poses.h"
#include "datasets/text/text_table.h"

namespace slammot {

// Name and folder; everything else is still empty.
Sequence foreign_sequence(const std::filesystem::path& folder);

// Appends a frame; refuses the table's line if its time [s] does not follow the one before.
void add_image(const TextTable& table, double timestamp, std::string image, Sequence& sequence);

void require_frames(const std::filesystem::path& file, const Sequence& sequence);

// Appends another camera of the rig with its images. Refuses, with file and line, one that stands
// where camera 0 does.
void add_camera(const std::filesystem::path& file, int line, const MountedCamera& camera,
                std::vector<std::string> images, Sequence& sequence);

// For each frame the image of `listed` that is nearest in time, "" where none is within `apart`
// [s]. Refuses the file that lists them where that is so of all frames.
std::vector<std::string> nearest_images(const std::filesystem::path& file, const Sequence& listed,
                                        const std::vector<Frame>& frames, double apart);

// The file name's ending, with the dot, of the image called `stem` + ending in a folder; where that
// one is missing, of the others; `.png` where there is none, so that what is missing can be named.
std::string image_ending(const std::filesystem::path& folder, const std::string& stem);

}  // namespace slammot
