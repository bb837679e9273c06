// Images of a room, and the sequence folder they are written to.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "datasets/sequence/sequence.h"
#include "frontend/rendering/room.h"

namespace slammot {

// A camera's image of a frame, 8-bit grey: RoomOptions::samples squared rays a pixel, mean over the
// exposure (which ends half its length after the frame's time), blur and noise. The same bytes for
// any number of threads, and of camera 0 with others beside it or without.
cv::Mat render(const Room& room, const RoomOptions& options, std::uint64_t seed, int frame,
               int camera = 0);

// Cameras, frames, images, true poses, and what the maker states: first camera, motion noise, and
// the prior of depth as the room has it. No observations: these are the front end's. Throws
// std::invalid_argument for a second camera outside the room.
Sequence room_sequence(const RoomOptions& options, std::uint64_t seed);

// Throws std::invalid_argument where room.yaml or images of somebody else would be replaced.
void require_own_room(const std::filesystem::path& folder);

// Writes a native folder of that sequence without observations, its images, and room.yaml, from
// which the truth of any pixel can be had again. Overrides of the options as `slammot simulate
// --set`; throws std::invalid_argument for what is not allowed, or as require_own_room().
Sequence write_room(RoomOptions options, const ScenarioOverrides& overrides, std::uint64_t seed,
                    const std::filesystem::path& folder);

// Where `images` (a folder with room.yaml; else nothing is done) was rendered: fills the truth of
// every track of `sequence`, which is where its first pixel lies on a surface, and states four
// known points of the first frame.
void add_room_truth(const std::filesystem::path& images, Sequence& sequence);
void add_room_truth(const Room& room, std::uint64_t seed, Sequence& sequence);

}  // namespace slammot
