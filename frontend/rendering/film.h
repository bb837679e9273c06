// Pictures of a run as files: every frame as PNG, a film, and a few smaller ones for the report.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <set>

#include "datasets/output/output_files.h"
#include "frontend/codecs/codecs.h"

namespace slammot {

// Writes `folder`/frames/%06d.png, `folder`/film.mp4 (MPEG-4) and `folder`/slider/%06d.jpg (at most
// about 60, spread over the run), and first the mark that says whose these are: ask
// require_output() before. What it does not write itself it never removes, but pictures of frames
// that an earlier film had and this one has not.
class Film {
 public:
  Film(std::filesystem::path folder, int pictures, double rate);

  // Pictures of one size. Throws std::runtime_error if a file cannot be written.
  void add(int frame, const cv::Mat& picture);
  void finish();

 private:
  void write_picture(const std::filesystem::path& file, const cv::Mat& picture, int quality);

  std::filesystem::path folder_;
  std::set<std::filesystem::path> written_;
  OutputFiles film_;
  double rate_;  // [Hz]
  int stride_;
  int added_ = 0;
  std::unique_ptr<Video> video_;
};

}  // namespace slammot
