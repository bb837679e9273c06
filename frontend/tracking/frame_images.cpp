#include "frontend/tracking/frame_images.h"

#include <fmt/format.h>

#include <algorithm>

#include "datasets/readers/image_reader.h"

namespace slammot {
namespace {

Loaded load(const FrameFunction& images, size_t place) {
  try {
    return {images(place), std::nullopt};
  } catch (const InputError& error) {
    return {{}, error};
  }
}

void refuse_missing_beside(const Sequence& images, const std::vector<std::string>& names) {
  std::error_code ignored;
  for (size_t i = 0; i < names.size(); ++i) {
    const std::filesystem::path file = images.folder / names[i];
    if (names[i].empty() || std::filesystem::is_regular_file(file, ignored)) continue;
    throw InputError(file, 0,
                     fmt::format("the other image of frame {} of {} is missing; --one-camera "
                                 "does without",
                                 i, names.size()));
  }
}

}  // namespace

FrameFiles::FrameFiles(const Sequence& images, bool mixed_colours)
    : images_(images),
      first_(
          images.camera_assumed ? cv::Size() : cv::Size(images.camera.width, images.camera.height),
          mixed_colours),
      others_(images.other_images.size(), ImageSource({}, mixed_colours)) {}

FrameImages FrameFiles::read(size_t place) {
  const auto file = [&](const std::string& name) { return images_.folder / name; };
  FrameImages frame{first_.read(file(images_.images[place])), {}, {}};
  for (size_t c = 0; c < others_.size(); ++c) {
    const std::string& name = images_.other_images[c][place];
    others_[c].expect(frame.image.size());
    frame.others.push_back(name.empty() ? cv::Mat() : others_[c].read(file(name)));
  }
  const auto& depths = images_.depth_images;
  if (!depths.empty() && !depths[place].empty()) {
    frame.depth = decode_depth(file(depths[place]), frame.image.size());
  }
  return frame;
}

void refuse_missing(const Sequence& images) {
  const std::vector<bool> present = images_present(images);
  const auto missing = std::find(present.begin(), present.end(), false);
  if (missing != present.end()) {
    const auto frame = static_cast<size_t>(missing - present.begin());
    throw InputError(images.folder / images.images[frame], 0,
                     fmt::format("frame {} of {} is missing", frame, present.size()));
  }
  for (const auto& names : images.other_images) refuse_missing_beside(images, names);
  refuse_missing_beside(images, images.depth_images);
}

FrameStream::FrameStream(size_t count, const FrameFunction& images, int threads)
    : count_(count),
      images_(images),
      policy_(threads == 1 ? std::launch::deferred : std::launch::async) {
  request();
}

Loaded FrameStream::next() {
  Loaded loaded = pending_.get();
  request();
  return loaded;
}

void FrameStream::request() {
  if (next_ == count_) return;
  const size_t place = next_++;
  pending_ = std::async(policy_, [this, place] { return load(images_, place); });
}

}  // namespace slammot
