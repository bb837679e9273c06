// Where the images of `slammot track` come from: a folder of a known layout, a plain one, a film.
#pragma once

#include <CLI/CLI.hpp>

#include "datasets/sequence/sequence.h"
#include "frontend/tracking/track_images.h"

namespace slammot {

struct ImageOptions {
  std::string images;          // a folder or a film
  std::string camera;          // a file; empty: as the folder states it
  std::optional<double> rate;  // [Hz] of a plain folder; of a film: instead of its own
  bool one_camera = false;     // neither another camera nor depth images
  std::string truth;           // a file, as groundtruth.tum; empty: as the folder has it
};

void add_image_options(CLI::App& command, ImageOptions& options);

struct ImagesToTrack {
  Sequence sequence;                  // frames without observations
  FrameFunction film;                 // the pictures of a film, else nothing
  std::string camera;                 // of which the camera is, for people
  std::vector<std::string> unused;    // what lies beside the images, and is not looked at
  std::vector<std::string> warnings;  // one line each
};

// Throws InputError for what is not there or not stated.
ImagesToTrack find_images(const ImageOptions& options);

}  // namespace slammot
