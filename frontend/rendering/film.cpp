#include "frontend/rendering/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace slammot {
namespace {

constexpr int kSliderPictures = 60;
constexpr int kSliderWidth = 960;  // [px] at most
constexpr int kSliderQuality = 80;

void write(const std::filesystem::path& file, const cv::Mat& image,
           const std::vector<int>& options = {}) {
  if (!cv::imwrite(file.string(), image, options)) {
    throw std::runtime_error(file.string() + ": cannot be written");
  }
}

}  // namespace

Film::Film(std::filesystem::path folder, int pictures, double rate)
    : folder_(std::move(folder)),
      rate_(rate),
      stride_(std::max(1, (pictures + kSliderPictures - 1) / kSliderPictures)) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  for (const char* part : {"frames", "slider"}) {
    std::filesystem::remove_all(folder_ / part);
    std::filesystem::create_directories(folder_ / part);
  }
}

void Film::add(int frame, const cv::Mat& picture) {
  write(folder_ / "frames" / fmt::format("{:06}.png", frame), picture);
  if (added_ % stride_ == 0) {
    cv::Mat small = picture;
    const double factor = static_cast<double>(kSliderWidth) / picture.cols;
    if (factor < 1.0) cv::resize(picture, small, {}, factor, factor, cv::INTER_AREA);
    write(folder_ / "slider" / fmt::format("{:06}.jpg", frame), small,
          {cv::IMWRITE_JPEG_QUALITY, kSliderQuality});
  }
  if (added_ == 0) {
    const std::string file = (folder_ / "film.mp4").string();
    video_.open(file, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), rate_, picture.size());
    if (!video_.isOpened()) throw std::runtime_error(file + ": cannot be written");
  }
  video_.write(picture);
  ++added_;
}

}  // namespace slammot
