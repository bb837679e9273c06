// Images from files, one at a time: grey, and all of them alike.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>

namespace slammot {

// Reads the images of one sequence. What the first one is (size, grey or colour) the others must be
// too, unless the size is known beforehand.
class ImageSource {
 public:
  // Size 0, 0: as the first image. Some writers store a colour image without colour in it as grey:
  // `mixed_colours` takes it.
  explicit ImageSource(cv::Size size = {}, bool mixed_colours = false)
      : size_(size), mixed_colours_(mixed_colours) {}

  // 8 bits, one channel; colour is converted. Throws InputError with the file and the reason:
  // missing, truncated, not an image, not 8 bits, another size, or grey among colour.
  cv::Mat read(const std::filesystem::path& file);

  cv::Size size() const { return size_; }

 private:
  cv::Size size_;
  bool mixed_colours_;
  std::optional<int> channels_;
};

// The image as it is stored: 8 bits, 1 or 3 channels (BGR). Throws InputError.
cv::Mat decode_image(const std::filesystem::path& file);

}  // namespace slammot
