// The module that frontend/codecs/codecs.h describes: OpenCV's image files and films.
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "frontend/codecs/codecs.h"

namespace slammot {
namespace {

class OpencvVideo : public Video {
 public:
  OpencvVideo(const std::filesystem::path& file, double rate, cv::Size size)
      : file_(file.string()),
        writer_(file_, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), rate, size) {}

  bool is_open() const { return writer_.isOpened(); }
  void add(const cv::Mat& picture) override {
    writer_.write(picture);
    ++added_;
  }
  // The writer tells of no failure: what it wrote is looked at.
  bool finish() override {
    writer_.release();
    return static_cast<int>(cv::VideoCapture(file_).get(cv::CAP_PROP_FRAME_COUNT)) == added_;
  }

 private:
  std::string file_;
  cv::VideoWriter writer_;
  int added_ = 0;
};

class OpencvVideoReader : public VideoReader {
 public:
  explicit OpencvVideoReader(const std::filesystem::path& file)
      : capture_(file.string(), cv::CAP_FFMPEG) {}

  bool is_open() const { return capture_.isOpened(); }
  std::optional<double> grab() override {
    if (!capture_.grab()) return std::nullopt;
    return capture_.get(cv::CAP_PROP_POS_MSEC) / 1000.0;
  }
  cv::Mat picture() override {
    cv::Mat picture;
    capture_.retrieve(picture);
    return picture.clone();  // what it points to is used again
  }

 private:
  cv::VideoCapture capture_;
};

class OpencvCodecs : public Codecs {
 public:
  cv::Mat decode(const std::string& bytes) const override {
    const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U,
                         const_cast<char*>(bytes.data()));  // only read
    return cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
  }

  std::string encode(const std::string& suffix, const cv::Mat& image,
                     int jpeg_quality) const override {
    std::vector<unsigned char> bytes;
    cv::imencode(suffix, image, bytes, {cv::IMWRITE_JPEG_QUALITY, jpeg_quality});
    return {bytes.begin(), bytes.end()};
  }

  std::unique_ptr<Video> open_video(const std::filesystem::path& file, double rate,
                                    cv::Size size) const override {
    auto video = std::make_unique<OpencvVideo>(file, rate, size);
    return video->is_open() ? std::move(video) : nullptr;
  }

  std::unique_ptr<VideoReader> read_video(const std::filesystem::path& file) const override {
    auto video = std::make_unique<OpencvVideoReader>(file);
    return video->is_open() ? std::move(video) : nullptr;
  }
};

}  // namespace
}  // namespace slammot

extern "C" const slammot::Codecs* slammot_codecs() {
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);  // quiet: what is wrong is said in one line of ours
  static const slammot::OpencvCodecs codecs;
  return &codecs;
}
