// From a sequence of images to the same sequence with measurements.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datasets/sequence/sequence.h"
#include "frontend/features/chessboard.h"
#include "frontend/tracking/frame_images.h"
#include "frontend/tracking/health.h"
#include "frontend/tracking/noise.h"
#include "frontend/tracking/tracker.h"

namespace slammot {

struct TrackOptions {
  TrackerOptions tracker;
  std::optional<Chessboard> chessboard;  // in the first image
  NoiseModel noise = NoiseModel::kCommon;
  bool skip_bad_frames = false;  // leave them out instead of throwing
  bool moving_start = false;     // leave out what the first image shows beside the board
  bool mixed_colours = false;    // take grey images among colour ones
  int threads = 0;               // 0: as many as there are cores
  std::function<void(int done, int total)> progress;  // after each image; may be empty
};

struct TrackedImages {
  Sequence sequence;  // frames 0, 1, ... of the images used; images as they were named
  std::optional<TrackNoise> noise;  // from which pixel_sigma follows; nothing: that is as it was
  int tracks = 0;
  TrackHealth health;
  std::vector<std::string> skipped;   // why, one line each
  std::vector<std::string> warnings;  // of what may be wrong with the images, one line each
};

// `images` as read_images() gives it. One image is decoded while the one before is tracked; none is
// kept. Throws InputError for the first bad image (or when none is good), and when the chessboard
// is not found; std::runtime_error for what OpenCV refuses.
TrackedImages track_images(const Sequence& images, const TrackOptions& options);

// The same of images that are no files: `read` gives those of each place of `images.frames`, and is
// called in their order. Of other cameras only those are used whose images have names.
TrackedImages track_images(const Sequence& images, const FrameFunction& read,
                           const TrackOptions& options);

}  // namespace slammot
