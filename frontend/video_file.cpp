#include "frontend/video_file.h"

#include <memory>
#include <opencv2/imgproc.hpp>

#include "datasets/sequence/plausible.h"
#include "frontend/codecs/codecs.h"

namespace slammot {
namespace {

std::shared_ptr<VideoReader> open(const std::filesystem::path& file) {
  std::shared_ptr<VideoReader> video = codecs().read_video(file);
  if (!video) throw InputError(file, 0, "is no film that can be read");
  return video;
}

}  // namespace

Sequence read_video(const std::filesystem::path& file, std::optional<double> rate) {
  Sequence sequence;
  sequence.folder = file;
  sequence.name = file.stem().string();
  sequence.camera.width = sequence.camera.height = 0;
  const auto video = open(file);
  double first = 0.0;
  for (int i = 0; const auto stated = video->grab(); ++i) {
    if (i == 0) first = *stated;
    const double time = rate ? i / *rate : *stated - first;
    if (i > 0 && step_fault(sequence.frames.back().timestamp, time)) {
      throw InputError(file, 0, "the times of the film's pictures do not increase: --rate HZ");
    }
    sequence.frames.push_back({i, time, {}, {}});
  }
  if (sequence.frames.empty()) throw InputError(file, 0, "the film has no picture");
  return sequence;
}

std::function<cv::Mat(std::size_t place)> video_images(const std::filesystem::path& file) {
  return [file, video = open(file)](std::size_t) {
    cv::Mat picture;
    if (video->grab()) picture = video->picture();
    if (picture.empty()) throw InputError(file, 0, "the film ended before its end");
    if (picture.channels() == 3) cv::cvtColor(picture, picture, cv::COLOR_BGR2GRAY);
    return picture;
  };
}

}  // namespace slammot
