#include "frontend/rendering/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/output/output_folder.h"

namespace slammot {
namespace {

constexpr int kSliderPictures = 60;
constexpr int kSliderWidth = 960;  // [px] at most
constexpr int kSliderQuality = 80;
constexpr const char* kParts[] = {"frames", "slider"};
constexpr const char* kFilm = "film.mp4";

// `000123.png`, as these pictures are called.
bool is_picture(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  return stem.size() >= 6 && stem.find_first_not_of("0123456789") == std::string::npos &&
         (file.extension() == ".png" || file.extension() == ".jpg");
}

}  // namespace

Film::Film(std::filesystem::path folder, int pictures, double rate)
    : folder_(std::move(folder)),
      rate_(rate),
      stride_(std::max(1, (pictures + kSliderPictures - 1) / kSliderPictures)) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  for (const char* part : kParts) std::filesystem::create_directories(folder_ / part);
  write_file(folder_ / kPicturesOutput.mark, std::string(kPicturesOutput.begins) + "\n");
}

void Film::write_picture(const std::filesystem::path& file, const cv::Mat& picture, int quality) {
  write_image(file, picture, quality);
  written_.insert(file);
}

void Film::add(int frame, const cv::Mat& picture) {
  write_picture(folder_ / kParts[0] / fmt::format("{:06}.png", frame), picture, kSliderQuality);
  if (added_ % stride_ == 0) {
    cv::Mat small = picture;
    const double factor = static_cast<double>(kSliderWidth) / picture.cols;
    if (factor < 1.0) cv::resize(picture, small, {}, factor, factor, cv::INTER_AREA);
    write_picture(folder_ / kParts[1] / fmt::format("{:06}.jpg", frame), small, kSliderQuality);
  }
  if (added_ == 0) {
    const std::filesystem::path file = folder_ / kFilm;
    video_ = codecs().open_video(film_.aside(file), rate_, picture.size());
    if (!video_) throw std::runtime_error(file.string() + ": cannot be written");
  }
  video_->add(picture);
  ++added_;
}

void Film::finish() {
  if (video_ && !video_->finish()) {
    throw std::runtime_error((folder_ / kFilm).string() + ": cannot be written");
  }
  film_.put_in_place();
  for (const char* part : kParts) {
    std::vector<std::filesystem::path> stale;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / part)) {
      if (is_picture(entry.path()) && !written_.contains(entry.path())) stale.push_back(entry);
    }
    for (const auto& file : stale) std::filesystem::remove(file);
  }
}

}  // namespace slammot
