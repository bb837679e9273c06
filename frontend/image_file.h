// Images from files, one at a time: 8 bits, grey, and all of them alike.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

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
  // missing, truncated, not an image, neither 8 nor 16 bits, another size, or grey among colour.
  cv::Mat read(const std::filesystem::path& file);

  // Of what is read from now on.
  void expect(cv::Size size) { size_ = size; }

  // Where the values of all 16-bit images read so far hardly reach their high byte: that.
  std::optional<std::string> depth_fault() const;

 private:
  cv::Size size_;
  bool mixed_colours_;
  std::optional<int> channels_;
  double largest_of_16_bits_ = 0.0;
};

// The image as it is stored, 1 or 3 channels (BGR), of 16 bits the high byte; of this size, where
// one is given. Throws InputError.
cv::Mat decode_image(const std::filesystem::path& file, std::optional<cv::Size> size = {});

// A mask: 8 bits, grey, or colour without colour in it; of this size, where it is not 0, 0. Throws
// InputError: the high byte of 16 bits and the brightness of a colour would be other numbers.
cv::Mat decode_mask(const std::filesystem::path& file, cv::Size size);

// A depth image: 16 bits, one channel, of this size. Throws InputError.
cv::Mat decode_depth(const std::filesystem::path& file, cv::Size size);

}  // namespace slammot
