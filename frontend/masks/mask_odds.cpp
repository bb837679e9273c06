#include "frontend/masks/mask_odds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "datasets/readers/plain_images.h"
#include "frontend/image_file.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

constexpr double kLargest8Bit = 255.0;

std::map<std::string, std::string> by_stem(const std::vector<std::string>& names,
                                           const Path& folder) {
  std::map<std::string, std::string> result;
  for (const std::string& name : names) {
    const auto [other, is_new] = result.emplace(Path(name).stem().string(), name);
    if (is_new) continue;
    throw InputError(folder, 0,
                     fmt::format("has two masks of one frame: {} and {}", other->second, name));
  }
  return result;
}

// Empty where no mask is named as an image; throws where only some are.
std::vector<std::string> named_as(const std::vector<std::string>& images,
                                  const std::vector<std::string>& masks, const Path& folder) {
  const auto named = by_stem(masks, folder);
  std::vector<std::string> result;
  std::string missing;
  for (const std::string& image : images) {
    const auto mask = named.find(Path(image).stem().string());
    if (mask != named.end()) {
      result.push_back(mask->second);
    } else if (missing.empty()) {
      missing = image;
    }
  }
  if (!result.empty() && !missing.empty()) {
    throw InputError(folder, 0, fmt::format("has no mask of the image {}", missing));
  }
  return result;
}

// The probability of moving at a pixel.
double moving_at(const cv::Mat& mask, const Eigen::Vector2d& pixel) {
  const auto within = [](double x, int size) {
    return std::clamp(static_cast<int>(std::lround(x)), 0, size - 1);
  };
  const int u = within(pixel.x(), mask.cols), v = within(pixel.y(), mask.rows);
  return mask.at<uchar>(v, u) / kLargest8Bit;
}

// Of masks that number classes or objects: `largest` value of all.
std::optional<std::string> brightness_fault(double largest) {
  constexpr double kMostOfClasses = 31.0;
  if (largest > kMostOfClasses) return std::nullopt;
  return fmt::format(
      "no mask is brighter than {} of 255: what moves for certain is 255, and these say that "
      "nothing does; are they numbers of classes or objects, or the masks of other images?",
      largest);
}

// Of its frame among all images; some may have been left out of what was tracked.
std::size_t place_of(const Frame& frame, const Sequence& images) {
  const auto at = std::ranges::lower_bound(images.frames, frame.timestamp, {}, &Frame::timestamp);
  return static_cast<std::size_t>(at - images.frames.begin());
}

}  // namespace

std::vector<Path> find_masks(const Path& folder, const Sequence& images) {
  constexpr double kAnyRate = 1.0;
  if (!std::filesystem::is_directory(folder)) throw InputError(folder, 0, "no such folder");
  const std::vector<std::string> all = read_plain_images(folder, kAnyRate).images;
  std::vector<std::string> names = named_as(images.images, all, folder);
  if (names.empty()) names = all;
  if (names.size() != images.frames.size()) {
    throw InputError(folder, 0,
                     fmt::format("has {} masks, and not one for each of {} frames", names.size(),
                                 images.frames.size()));
  }
  std::vector<Path> masks;
  for (const std::string& name : names) masks.push_back(folder / name);
  // All of them now: tracking takes hours.
  cv::Size size{images.camera.width, images.camera.height};
  for (const Path& mask : masks) size = decode_mask(mask, size).size();
  return masks;
}

MaskOdds odds_by_masks(const std::vector<Path>& masks, const Sequence& images,
                       const Sequence& tracked) {
  const cv::Size size{tracked.camera.width, tracked.camera.height};
  MaskOdds result;
  double largest = 0.0;
  for (const Frame& frame : tracked.frames) {
    const cv::Mat mask = decode_mask(masks.at(place_of(frame, images)), size);
    double most = 0.0;
    cv::minMaxLoc(mask, nullptr, &most);
    largest = std::max(largest, most);
    // Where a track begins: what is said before any evidence must not know the frames after it.
    for (const Observation& z : frame.observations) {
      result.p_static.try_emplace(z.track, 1.0 - moving_at(mask, z.pixel));
    }
  }
  if (auto fault = brightness_fault(largest)) result.warnings.push_back(std::move(*fault));
  return result;
}

}  // namespace slammot
