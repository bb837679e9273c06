// A second camera and depth images: matches under a known disparity, what the geometry refuses, and
// folders of both from their images to measurements.
#include "frontend/tracking/other_view.h"

#include <fmt/format.h>

#include "datasets/native/native_reader.h"
#include "frontend/tracking/depth_image.h"
#include "tests/frontend/images_fixture.h"
#include "tests/frontend/texture.h"

namespace slammot {
namespace {

const Camera kPinhole{320, 240, 300.0, 300.0, 159.5, 119.5, PinholeLens{}};
const MountedCamera kToTheRight{kPinhole, Eigen::Quaterniond::Identity(), {0.2, 0.0, 0.0}};

// x_right = x_left - disparity - slope y.
Warp moved_by(double disparity, double slope = 0.0, double down = 0.0) {
  Warp warp;
  warp.A << 1.0, -slope, 0.0, 1.0;
  warp.t = {-disparity, down};
  return warp;
}

TEST(OtherView, FindsEachPointWhereTheDisparityHasIt) {
  const cv::Size size(320, 240);
  Tracker tracker{TrackerOptions{}};
  OtherView right(kPinhole, kToTheRight, 1);
  for (int k = 0; k < 3; ++k) {  // the camera comes nearer
    const Warp left = moved_by(-2.0 * k), pair = moved_by(7.3 + 2.0 * k, 0.08);
    const Warp both{pair.A * left.A, pair.A * left.t + pair.t};
    const auto z = tracker.process(textured(size, left));
    const auto views = right.match(tracker, textured(size, both), z);
    EXPECT_GT(views.size(), z.size() / 2) << k;
    auto first = z.begin();
    for (const Observation& view : views) {
      while (first->track != view.track) ++first;
      EXPECT_EQ(view.camera, 1);
      EXPECT_LT((view.pixel - (pair.A * first->pixel + pair.t)).norm(), 0.3) << view.track;
    }
  }
}

TEST(OtherView, RefusesWhatIsNoPointOfTheScene) {
  const cv::Size size(320, 240);
  const auto found = [&](const Warp& pair) {
    Tracker tracker{TrackerOptions{}};
    const auto z = tracker.process(textured(size, {}));
    return OtherView(kPinhole, kToTheRight, 1).match(tracker, textured(size, pair), z).size();
  };
  EXPECT_GT(found(moved_by(8.0, 0.0, 1.0)), 20u);
  EXPECT_EQ(found(moved_by(8.0, 0.0, 4.0)), 0u);  // off the epipolar line
  EXPECT_EQ(found(moved_by(-6.0)), 0u);           // beyond infinity
}

TEST(OtherView, KnowsTheEpipolarLineOfATurnedAndDistortedPair) {
  Camera first = kPinhole, second = kPinhole;
  first.lens = RadtanLens{{-0.28, 0.07, 0.0002, 0.0, 0.0}};
  second.lens = EquidistantLens{{0.01, -0.002, 0.0, 0.0}};
  const Eigen::Quaterniond R = exp_so3(Eigen::Vector3d(0.02, -0.05, 0.03));
  const MountedCamera other(second, R, {0.1, 0.02, 0.05});
  const OtherView view(first, other, 1);
  for (const double depth : {0.8, 3.0, 50.0}) {
    const Eigen::Vector3d ray(0.15, -0.1, 1.0);
    const Eigen::Vector2d pixel = first.project(ray)->pixel;
    const Eigen::Vector2d seen = second.project(other.ray(ray, 1.0 / depth))->pixel;
    EXPECT_LT(view.off_line(pixel, seen).value(), 1e-6) << depth;
    const double off = view.off_line(pixel, seen + Eigen::Vector2d(0.0, 3.0)).value();
    EXPECT_NEAR(off, 3.0, 0.5) << depth;
  }
  // Nothing is before a camera that looks back.
  const MountedCamera back(second, exp_so3(Eigen::Vector3d(0.0, 3.1, 0.0)), {0.1, 0.0, 0.0});
  EXPECT_FALSE(OtherView(first, back, 1).off_line({159.0, 119.0}, {159.0, 119.0}));
}

TEST(DepthImage, GivesTheMedianAndWhatTheEdgeLeaves) {
  cv::Mat image(20, 30, CV_16U, cv::Scalar(10000));
  image.colRange(15, 30).setTo(15000);
  image(cv::Rect(0, 0, 8, 8)).setTo(0);
  image.at<ushort>(12, 6) = 0;
  std::vector<Observation> z{
      {0, {6.2, 11.8}}, {1, {15.4, 12.0}}, {2, {4.0, 4.0}}, {3, {7.0, 7.0}}, {4, {29.0, 19.0}}};
  measure_depths(image, 1.0 / 5000.0, z);
  EXPECT_DOUBLE_EQ(z[0].depth, 2.0);
  EXPECT_DOUBLE_EQ(z[0].depth_sigma, 0.01 + 0.005 * 4.0);
  EXPECT_DOUBLE_EQ(z[1].depth, 3.0);
  EXPECT_DOUBLE_EQ(z[1].depth_sigma, 0.01 + 0.005 * 9.0 + 0.5);
  EXPECT_FALSE(z[2].has_depth());
  EXPECT_TRUE(z[3].has_depth());  // five of nine
  EXPECT_FALSE(z[4].has_depth());
}

// Six images of a texture that moves, as KITTI and TUM RGB-D store them.
class Beside : public Images {
 protected:
  void SetUp() override {
    std::string times;
    for (int i = 0; i < kCount; ++i) {
      write(fmt::format("image_0/{:06}.png", i), textured(kSize, moved_by(-2.0 * i)));
      write(fmt::format("image_1/{:06}.png", i), textured(kSize, moved_by(9.0 - 2.0 * i)));
      times += fmt::format("{}\n", 0.1 * i);
    }
    test::write_text(sequence() / "times.txt", times);
    state_baseline(150.0);
  }
  void state_baseline(double fx_times_baseline) {
    test::write_text(sequence() / "calib.txt", fmt::format("P0: 300 0 100 0 0 300 75 0 0 0 1 0\n"
                                                           "P1: 300 0 100 {} 0 300 75 0 0 0 1 0\n",
                                                           -fx_times_baseline));
  }
  void write(const std::string& name, const cv::Mat& image) {
    std::filesystem::create_directories((sequence() / name).parent_path());
    cv::imwrite((sequence() / name).string(), image);
  }
  void expect_refused(const std::string& reason) {
    EXPECT_EQ(track(), 2);
    EXPECT_NE(error_.find(reason), std::string::npos) << error_;
    EXPECT_EQ(std::ranges::count(error_, '\n'), 1) << error_;
  }

  const cv::Size kSize{200, 150};
};

TEST_F(Beside, TwoCamerasAreTracked) {
  ASSERT_EQ(track(), 0) << error_;
  EXPECT_NE(out_.find("camera 1, 0.5 m from camera 0, matches "), std::string::npos) << out_;
  EXPECT_EQ(out_.find("not used"), std::string::npos) << out_;
  const Sequence tracked = read_native(output());
  ASSERT_EQ(tracked.other_cameras.size(), 1u);
  EXPECT_NEAR(tracked.other_cameras[0].t.x(), 0.5, 1e-12);
  EXPECT_EQ(tracked.other_cameras[0].lens.width, 200);
  for (const Frame& frame : tracked.frames) {
    EXPECT_GT(frame.other_views.size(), frame.observations.size() / 2);
  }
}

TEST_F(Beside, OneCameraIsAsIfTheOtherWereNotThere) {
  ASSERT_EQ(track("--one-camera"), 0) << error_;
  EXPECT_NE(out_.find("not used image_1: one camera's images are\n"), std::string::npos) << out_;
  const auto text = [&](const char* name) { return test::read_text(output() / name); };
  const std::string alone = text("observations.csv"), settings = text("sequence.yaml");
  std::filesystem::remove_all(sequence() / "image_1");
  ASSERT_EQ(track(), 0) << error_;
  EXPECT_EQ(text("observations.csv"), alone);
  EXPECT_EQ(text("sequence.yaml"), settings);
}

// What `track` writes names the images of both: a native rig, which can be tracked as well.
TEST_F(Beside, ANativeRigNamesBoth) {
  ASSERT_EQ(track(), 0) << error_;
  const Path again = folder_.path() / "again";
  const std::string on =
      "track '" + output().string() + "' --force --output '" + again.string() + "' ";
  ASSERT_EQ(slammot(on), 0) << error_;
  EXPECT_EQ(out_.find("not used"), std::string::npos) << out_;
  EXPECT_EQ(test::read_text(again / "observations.csv"),
            test::read_text(output() / "observations.csv"));
  EXPECT_TRUE(std::filesystem::equivalent(again / read_native(again).other_images.at(0).at(3),
                                          sequence() / "image_1/000003.png"));
  ASSERT_EQ(slammot(on + "--one-camera"), 0) << error_;
  EXPECT_NE(out_.find("not used the other cameras of sequence.yaml: one camera's images are\n"),
            std::string::npos)
      << out_;
  EXPECT_TRUE(read_native(again).other_images.empty());
  std::filesystem::remove(sequence() / "image_1/000003.png");
  EXPECT_EQ(slammot(on), 2);
  EXPECT_NE(error_.find("000003.png: the other image of frame 3 of 6 is missing"),
            std::string::npos)
      << error_;
}

TEST_F(Beside, ACameraOfOnesOwnIsOne) {
  const Path file = folder_.path() / "camera.yaml";
  test::write_text(file,
                   "{model: pinhole, width: 200, height: 150, fx: 300, fy: 300, cx: 100, "
                   "cy: 75}\n");
  ASSERT_EQ(track("--camera '" + file.string() + "'"), 0) << error_;
  EXPECT_NE(out_.find("not used image_1: one camera's images are\n"), std::string::npos) << out_;
  EXPECT_TRUE(read_native(output()).other_cameras.empty());
}

TEST_F(Beside, AStartWithMoversHasNoOtherViewsEither) {
  ASSERT_EQ(track("--moving-start --noise alignment"), 0) << error_;
  const Sequence tracked = read_native(output());
  EXPECT_TRUE(tracked.frames[0].other_views.empty());
  EXPECT_FALSE(tracked.frames[1].other_views.empty());
}

TEST_F(Beside, BadPairsAreRefusedOrLeftOut) {
  state_baseline(0.0);
  expect_refused("calib.txt:2: the camera stands where the first does");
  state_baseline(150.0);
  const Path third = sequence() / "image_1/000003.png";
  write("image_1/000003.png", textured({100, 80}, {}));
  expect_refused("000003.png: the image is 100x80, not 200x150");
  ASSERT_EQ(track("--skip-bad-frames"), 0) << error_;
  EXPECT_EQ(read_native(output()).frames.size(), 5u);
  std::filesystem::remove(third);
  expect_refused("000003.png: the other image of frame 3 of 6 is missing");
  ASSERT_EQ(track("--skip-bad-frames"), 0) << error_;
  EXPECT_EQ(read_native(output()).frames.size(), 5u);
}

TEST_F(Beside, DepthImagesAreMeasured) {
  std::string rgb, depth;
  for (int i = 0; i < kCount; ++i) {
    rgb += fmt::format("{} image_0/{:06}.png\n", 0.1 * i, i);
    if (i != 2) depth += fmt::format("{} depth/{}.png\n", 0.1 * i + 0.015, i);
    write(fmt::format("depth/{}.png", i), cv::Mat(kSize, CV_16U, cv::Scalar(12500)));
  }
  std::filesystem::remove_all(sequence() / "image_1");
  test::write_text(sequence() / "rgb.txt", rgb);
  test::write_text(sequence() / "depth.txt", depth);
  const std::string camera = "--camera '" + (folder_.path() / "camera.yaml").string() + "'";
  test::write_text(folder_.path() / "camera.yaml",
                   "{model: pinhole, width: 200, height: 150, fx: 300, fy: 300, cx: 100, cy: "
                   "75}\n");
  ASSERT_EQ(track(camera), 0) << error_;
  EXPECT_NE(out_.find("depth images measure "), std::string::npos) << out_;
  const Sequence tracked = read_native(output());
  for (const Observation& z : tracked.frames[1].observations) EXPECT_EQ(z.depth, 2.5);
  for (const Observation& z : tracked.frames[2].observations) EXPECT_FALSE(z.has_depth());
  ASSERT_EQ(track(camera + " --one-camera"), 0) << error_;
  EXPECT_NE(out_.find("not used depth.txt"), std::string::npos) << out_;
  EXPECT_FALSE(measures_scale(read_native(output())));
  write("depth/4.png", textured(kSize, {}));
  EXPECT_EQ(track(camera), 2);
  EXPECT_NE(error_.find("4.png: a depth image has 16 bits"), std::string::npos) << error_;
}

}  // namespace
}  // namespace slammot
