// Six images of a shifted scene as a native sequence, and the program run on them.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

#include "tests/eval/fixture.h"
#include "tests/paths.h"

namespace slammot {

using Path = std::filesystem::path;

inline cv::Mat scene(int shift) {
  cv::Mat image(120, 160, CV_8U);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double x = u - shift, y = v;
      image.at<uchar>(v, u) = static_cast<uchar>(128.0 + 50.0 * std::sin(0.31 * x + 0.2 * y) +
                                                 50.0 * std::sin(0.17 * x - 0.29 * y));
    }
  }
  return image;
}

class Images : public ::testing::Test {
 protected:
  static constexpr int kCount = 6;

  void SetUp() override {
    std::string frames = "frame,timestamp,image\n";
    for (int i = 0; i < kCount; ++i) {
      frames += std::to_string(i) + "," + std::to_string(0.1 * i) + "," + name(i) + "\n";
      std::filesystem::create_directories(image(i).parent_path());
      cv::imwrite(image(i).string(), scene(2 * i));
    }
    test::write_text(sequence() / "frames.csv", frames);
    test::write_text(
        sequence() / "sequence.yaml",
        "format: slammot-sequence-1\nname: small\npixel_sigma: 1\ncamera: {model: pinhole, "
        "width: 160, height: 120, fx: 100, fy: 100, cx: 79.5, cy: 59.5}\n");
  }

  Path sequence() const { return folder_.path() / "images"; }
  Path output() const { return folder_.path() / "tracked"; }
  static std::string name(int i) {
    return "i/" + std::to_string(i) + (i % 2 == 0 ? ".png" : ".jpg");
  }
  // A file of its camera.
  std::string camera() const {
    const Path file = folder_.path() / "camera.yaml";
    test::write_text(
        file, "{model: pinhole, width: 160, height: 120, fx: 100, fy: 100, cx: 79.5, cy: 59.5}\n");
    return file.string();
  }
  Path image(int i) const { return sequence() / name(i); }

  int track(const std::string& more = "") {
    return slammot("track '" + sequence().string() + "' --output '" + output().string() +
                   "' --force " + more);
  }
  int slammot(const std::string& arguments) {
    const std::string command = std::string("'") + test::kBinary + "' " + arguments + " >'" +
                                (folder_.path() / "out").string() + "' 2>'" +
                                (folder_.path() / "error").string() + "'";
    const int status = std::system(command.c_str());
    out_ = test::read_text(folder_.path() / "out");
    error_ = test::read_text(folder_.path() / "error");
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  test::TemporaryFolder folder_;
  std::string out_, error_;
};

}  // namespace slammot
