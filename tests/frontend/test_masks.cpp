// `track --masks`: odds of rest by the grey values of somebody else's masks.
#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "datasets/native/native_reader.h"
#include "tests/frontend/images_fixture.h"

namespace slammot {
namespace {

class Masks : public Images {
 protected:
  // What lies right of column `edge` moves, with probability value/255.
  static cv::Mat mask(int edge, int value = 255) {
    cv::Mat image(120, 160, CV_8U, cv::Scalar(0));
    image.colRange(edge, 160).setTo(cv::Scalar(value));
    return image;
  }
  Path folder() const { return folder_.path() / "masks"; }
  void write(int frame, const cv::Mat& image, const char* name = "{}.png") const {
    std::filesystem::create_directories(folder());
    cv::imwrite((folder() / fmt::format(fmt::runtime(name), frame)).string(), image);
  }
  static bool is_of(const Frame& frame, int track) {
    return std::ranges::count(frame.observations, track, &Observation::track) > 0;
  }
  int track_masked(const std::string& more = "") {
    return track("--masks '" + folder().string() + "' " + more);
  }
};

// The scene is shifted by 2 px a frame, and its masks with it; at their edge a track may be on
// either side.
TEST_F(Masks, SayOfATrackWhatTheyShowAtItsPixels) {
  for (int i = 0; i < kCount; ++i) write(i, mask(80 + 2 * i));
  ASSERT_EQ(track_masked(), 0) << error_;
  EXPECT_EQ(error_, "");
  EXPECT_NE(out_.find("tracks move rather than rest"), std::string::npos) << out_;
  const Sequence tracked = read_native(output());
  std::map<int, double> first;  // column, in the scene's own
  for (const Frame& frame : tracked.frames) {
    for (const Observation& z : frame.observations) {
      first.emplace(z.track, z.pixel.x() - 2.0 * frame.index);
    }
  }
  ASSERT_EQ(tracked.p_static.size(), first.size());
  int moving = 0;
  for (const auto& [track, u] : first) {
    if (std::abs(u - 80.0) < 2.0) continue;
    EXPECT_EQ(tracked.p_static.at(track), u < 80.0 ? 1.0 : 0.0) << u;
    moving += u > 80.0 ? 1 : 0;
  }
  EXPECT_GT(moving, 5);
  // In order, where they have names of their own; the middle of the range is taken as it is, and
  // what later masks say of a track is not asked.
  std::filesystem::remove_all(folder());
  for (int i = 0; i < kCount; ++i) write(i, mask(0, 51 * (i < 3 ? i + 1 : 5)), "mask_{}.png");
  ASSERT_EQ(track_masked("--skip-bad-frames"), 0) << error_;
  const Sequence again = read_native(output());
  for (const Observation& z : again.frames[3].observations) {
    if (!is_of(again.frames[0], z.track)) continue;
    EXPECT_NEAR(again.p_static.at(z.track), 1.0 - 0.2, 1e-12);
  }
  ASSERT_EQ(track(), 0) << error_;
  EXPECT_FALSE(std::filesystem::exists(output() / "priors.csv"));
}

TEST_F(Masks, ThatDoNotFitAreRefused) {
  const auto refused = [&](const char* reason) {
    EXPECT_EQ(track_masked(), 2);
    EXPECT_NE(error_.find(reason), std::string::npos) << error_;
    EXPECT_EQ(std::count(error_.begin(), error_.end(), '\n'), 1) << error_;
  };
  refused("masks: no such folder");
  for (int i = 0; i < kCount; ++i) write(i, mask(80));
  write(2, mask(80).colRange(0, 100));
  refused("2.png: the image is 100x120, not 160x120");
  std::filesystem::remove(folder() / "2.png");
  refused("masks: has no mask of the image i/2.png");
  std::filesystem::remove_all(folder());
  for (int i = 0; i < kCount - 1; ++i) write(i, mask(80), "mask_{}.png");
  refused("masks: has 5 masks, and not one for each of 6 frames");
  const cv::Scalar palette(0, 0, 128);  // object 1 of DAVIS
  write(5, cv::Mat(120, 160, CV_8UC3, palette), "mask_{}.png");
  refused("mask_5.png: a mask is grey, of 8 bits");
  write(5, cv::Mat(120, 160, CV_16U, cv::Scalar(255)), "mask_{}.png");
  refused("mask_5.png: a mask is grey, of 8 bits");
  write(5, cv::Mat(120, 160, CV_8UC3, cv::Scalar::all(200)), "mask_{}.png");
  EXPECT_EQ(track_masked(), 0) << error_;
  std::filesystem::remove_all(folder());
  for (int i = 0; i < kCount; ++i) write(i, mask(80));
  write(2, mask(80), "{}.jpg");
  refused("masks: has two masks of one frame");
}

TEST_F(Masks, OfNumberedClassesAreHinted) {
  for (int i = 0; i < kCount; ++i) write(i, mask(80, 1));
  ASSERT_EQ(track_masked(), 0) << error_;
  EXPECT_NE(error_.find("numbers of classes or objects"), std::string::npos) << error_;
}

// What was left out takes its mask along.
TEST_F(Masks, FollowTheirFramesWhereSomeAreSkipped) {
  for (int i = 0; i < kCount; ++i) write(i, mask(0, i == 0 ? 255 : 0), "mask_{}.png");
  test::write_text(image(0), "no image");
  ASSERT_EQ(track_masked("--skip-bad-frames"), 0) << error_;
  for (const auto& [track, p] : read_native(output()).p_static) EXPECT_EQ(p, 1.0) << track;
}

}  // namespace
}  // namespace slammot
