#include "frontend/rendering/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>

namespace slammot {
namespace {

constexpr int kSliderPictures = 60;
constexpr int kSliderWidth = 960;  // [px] at most
constexpr int kSliderQuality = 80;

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
  write_image(folder_ / "frames" / fmt::format("{:06}.png", frame), picture);
  if (added_ % stride_ == 0) {
    cv::Mat small = picture;
    const double factor = static_cast<double>(kSliderWidth) / picture.cols;
    if (factor < 1.0) cv::resize(picture, small, {}, factor, factor, cv::INTER_AREA);
    write_image(folder_ / "slider" / fmt::format("{:06}.jpg", frame), small, kSliderQuality);
  }
  if (added_ == 0) {
    const std::filesystem::path file = folder_ / "film.mp4";
    video_ = codecs().open_video(file, rate_, picture.size());
    if (!video_) throw std::runtime_error(file.string() + ": cannot be written");
  }
  video_->add(picture);
  ++added_;
}

}  // namespace slammot
