#include "frontend/image_file.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>
#include <string_view>

#include "datasets/sequence/sequence.h"
#include "datasets/text/text_table.h"
#include "frontend/codecs/codecs.h"

namespace slammot {
namespace {

using namespace std::string_view_literals;

// A decoder may fill up what is missing with grey and only mutter: so the end is looked for first.
// Some writers pad a file, hence not the very last bytes.
bool is_truncated(std::string_view bytes) {
  constexpr size_t kPadding = 512;
  bytes = bytes.substr(0, bytes.find_last_not_of('\0') + 1);
  const std::string_view tail =
      bytes.size() > kPadding ? bytes.substr(bytes.size() - kPadding) : bytes;
  if (bytes.starts_with("\xFF\xD8"sv)) return tail.find("\xFF\xD9"sv) == tail.npos;
  if (bytes.starts_with("\x89PNG"sv)) return tail.find("IEND\xAE\x42\x60\x82"sv) == tail.npos;
  return false;
}

const char* colour_name(int channels) { return channels == 1 ? "grey" : "colour"; }

// Of 8 or 16 bits, 1 or 3 channels.
cv::Mat decode(const std::filesystem::path& file) {
  const std::string bytes = read_text_file(file);
  if (bytes.empty()) throw InputError(file, 0, "the image is empty");
  if (is_truncated(bytes)) throw InputError(file, 0, "the image is truncated");
  cv::Mat image;
  try {
    image = codecs().decode(bytes);
    if (!image.empty() && image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_BGRA2BGR);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) throw InputError(file, 0, "is truncated or no image");
  if (image.depth() != CV_8U && image.depth() != CV_16U) {
    throw InputError(file, 0, "the image has neither 8 nor 16 bits a channel");
  }
  if (image.channels() == 2) throw InputError(file, 0, "the image has two channels");
  return image;
}

cv::Mat eight_bits(cv::Mat image) {
  // OpenCV rounds: so much less that each value becomes its high byte.
  constexpr double kStep = 256.0;
  if (image.depth() == CV_16U) image.convertTo(image, CV_8U, 1.0 / kStep, -0.5 + 0.5 / kStep);
  return image;
}

void require_size(const std::filesystem::path& file, const cv::Mat& image, cv::Size size) {
  if (image.size() == size) return;
  throw InputError(file, 0,
                   fmt::format("the image is {}x{}, not {}x{}", image.cols, image.rows, size.width,
                               size.height));
}

}  // namespace

cv::Mat decode_image(const std::filesystem::path& file, std::optional<cv::Size> size) {
  cv::Mat image = eight_bits(decode(file));
  if (size) require_size(file, image, *size);
  return image;
}

cv::Mat decode_mask(const std::filesystem::path& file, cv::Size size) {
  cv::Mat image = decode(file);
  if (size.area() > 0) require_size(file, image, size);
  bool is_grey = image.depth() == CV_8U;
  if (is_grey && image.channels() == 3) {
    std::vector<cv::Mat> channels;
    cv::split(image, channels);
    is_grey = cv::norm(channels[0], channels[1], cv::NORM_INF) == 0.0 &&
              cv::norm(channels[0], channels[2], cv::NORM_INF) == 0.0;
    image = channels[0];
  }
  if (!is_grey) throw InputError(file, 0, "a mask is grey, of 8 bits: 0 rests, 255 moves");
  return image;
}

cv::Mat decode_depth(const std::filesystem::path& file, cv::Size size) {
  cv::Mat image = decode(file);
  if (image.type() != CV_16UC1) throw InputError(file, 0, "a depth image has 16 bits, no colour");
  require_size(file, image, size);
  return image;
}

cv::Mat ImageSource::read(const std::filesystem::path& file) {
  cv::Mat image = decode(file);
  if (size_.area() == 0) size_ = image.size();
  require_size(file, image, size_);
  if (!channels_) channels_ = image.channels();
  if (image.channels() != *channels_ && !mixed_colours_) {
    throw InputError(
        file, 0,
        fmt::format("the image is {}, those before it are {}; --mixed-colours takes both",
                    colour_name(image.channels()), colour_name(*channels_)));
  }
  if (image.depth() == CV_16U) {
    double largest = 0.0;
    cv::minMaxLoc(image.reshape(1), nullptr, &largest);
    largest_of_16_bits_ = std::max(largest_of_16_bits_, largest);
    image = eight_bits(image);
  }
  if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
  return image;
}

// Cameras of 10, 12 or 14 bits whose values were stored as they are.
std::optional<std::string> ImageSource::depth_fault() const {
  constexpr double kMostOf14Bits = 16383.0;
  if (largest_of_16_bits_ == 0.0 || largest_of_16_bits_ > kMostOf14Bits) return std::nullopt;
  return fmt::format(
      "no value of the 16-bit images is above {}: their high byte, which is used, has {} grey "
      "levels; scale the images to 16 bits",
      largest_of_16_bits_, static_cast<int>(largest_of_16_bits_) / 256 + 1);
}

}  // namespace slammot
