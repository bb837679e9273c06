// Image files and films. OpenCV's codecs bring some two hundred shared libraries along (GDAL,
// ffmpeg, GStreamer), so they stand in a module of their own, codecs/, that is loaded at the first
// image.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace slammot {

class Video {
 public:
  virtual ~Video() = default;
  virtual void add(const cv::Mat& picture) = 0;
  // Completes the file; false if it does not hold what was added.
  virtual bool finish() = 0;
};

// The pictures of a film, one after the other.
class VideoReader {
 public:
  virtual ~VideoReader() = default;
  // Goes to the next picture and gives its time [s]; nothing after the last.
  virtual std::optional<double> grab() = 0;
  virtual cv::Mat picture() = 0;
};

// What the module does. Its failures are empty images and null pointers, or a cv::Exception.
class Codecs {
 public:
  virtual ~Codecs() = default;

  // With the depth and the channels that are stored.
  virtual cv::Mat decode(const std::string& bytes) const = 0;

  // The bytes of a file; the suffix (`.png`) says of which kind. `jpeg_quality` is at most 100.
  virtual std::string encode(const std::string& suffix, const cv::Mat& image,
                             int jpeg_quality) const = 0;

  // MPEG-4, `rate` in Hz.
  virtual std::unique_ptr<Video> open_video(const std::filesystem::path& file, double rate,
                                            cv::Size size) const = 0;

  virtual std::unique_ptr<VideoReader> read_video(const std::filesystem::path& file) const = 0;
};

// The module's one function.
inline constexpr char kCodecsEntry[] = "slammot_codecs";
using CodecsEntry = const Codecs*();

// Loads the module when first called. Throws std::runtime_error if it cannot be loaded.
const Codecs& codecs();

// Throws std::runtime_error if the file cannot be written.
void write_image(const std::filesystem::path& file, const cv::Mat& image, int jpeg_quality = 95);

}  // namespace slammot
