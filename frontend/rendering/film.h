// Pictures of a run as files: every frame as PNG, a film, and a few smaller ones for the report.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>

#include "frontend/codecs/codecs.h"

namespace slammot {

// Writes `folder`/frames/%06d.png, `folder`/film.mp4 (MPEG-4) and `folder`/slider/%06d.jpg (at most
// about 60, spread over the run). What an earlier run left in these is removed first.
class Film {
 public:
  Film(std::filesystem::path folder, int pictures, double rate);

  // Pictures of one size. Throws std::runtime_error if a file cannot be written.
  void add(int frame, const cv::Mat& picture);

 private:
  std::filesystem::path folder_;
  double rate_;  // [Hz]
  int stride_;
  int added_ = 0;
  std::unique_ptr<Video> video_;
};

}  // namespace slammot
