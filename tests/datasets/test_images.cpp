// Foreign image layouts: what is listed, the truth in our conventions, and what is refused.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "datasets/readers/image_reader.h"
#include "datasets/readers/reader.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

using test::write_text;
using ::testing::HasSubstr;

class Layout : public ::testing::Test {
 protected:
  void put(const std::string& name, const std::string& text = "") {
    write_text(folder_.path() / name, text);
  }
  Sequence read() const { return read_images(folder_.path()); }
  std::string refusal() const {
    return test::refusal_of([&] { read(); });
  }

  void put_kitti() {
    put("calib.txt", "P0: 700 0 600 0 0 700 180 0 0 0 1 0\nP2: 700 0 600 70 0 700 180 0 0 0 1 0\n");
    put("times.txt", "0\n0.1\n");
    put("image_2/000000.png");
    put("image_2/000001.png");
    // Half a turn about y after one step along z.
    put("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n-1 0 0 0 0 1 0 0 0 0 -1 5\n");
  }
  void put_euroc() {
    put("mav0/cam0/data.csv", "#timestamp [ns],filename\n1000000000,a.png\n1100000000,b.png\n");
    put("mav0/cam0/sensor.yaml",
        "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n"
        "  data: [0, -1, 0, 0.5,\n         1, 0, 0, 0,\n         0, 0, 1, 0,\n         0, 0, 0, "
        "1]\n"
        "rate_hz: 20\nresolution: [752, 480]\ncamera_model: pinhole\n"
        "intrinsics: [458, 457, 367, 248]\ndistortion_model: radial-tangential\n"
        "distortion_coefficients: [-0.28, 0.07, 0.0002, 0.00002]\n");
    put("mav0/state_groundtruth_estimate0/data.csv",
        "#timestamp,px,py,pz,qw,qx,qy,qz\n"
        "1000000000,1,2,3,1,0,0,0\n1050000000,1,2,3,1,0,0,0\n1060000000,1,2,3,1,0,0,0\n"
        "1110000000,2,2,3,1,0,0,0\n");
  }

  test::TemporaryFolder folder_;
};

TEST_F(Layout, TumRgbdByItsHead) {
  put("rgb.txt",
      "# color images\n# file: 'rgbd_dataset_freiburg3_x.bag'\n10.0 rgb/a.png\n10.1 rgb/b.png\n");
  put("groundtruth.txt", "# t\n9.99 0 0 0 0 0 0 1\n10.01 2 0 0 0 0 0 1\n10.1 3 0 0 0 0 0 1\n");
  const Sequence sequence = read();
  EXPECT_EQ(sequence.images, (std::vector<std::string>{"rgb/a.png", "rgb/b.png"}));
  EXPECT_EQ(sequence.camera.fx, 535.4);
  ASSERT_TRUE(sequence.truth[0] && sequence.truth[1]);
  EXPECT_NEAR(sequence.truth[0]->position.x(), 1.0, 1e-9);  // halfway between its neighbours
  EXPECT_EQ(sequence.truth[1]->position.x(), 3.0);
}

TEST_F(Layout, TumRgbdsThreeCameras) {
  const auto camera_of = [&](const char* name) {
    put("rgb.txt", fmt::format("# color images\n# file: '{}.bag'\n10.0 rgb/a.png\n", name));
    return read().camera;
  };
  const Camera first = camera_of("rgbd_dataset_freiburg1_rpy");
  EXPECT_EQ(first.fx, 517.3);
  ASSERT_EQ(lens_name(first.lens), "radtan");
  EXPECT_EQ(std::get<RadtanLens>(first.lens).coefficients[4], 1.1633);
  EXPECT_EQ(camera_of("rgbd_dataset_freiburg2_desk").fy, 521.0);
  EXPECT_EQ(lens_name(camera_of("rgbd_dataset_freiburg3_x").lens), "pinhole");
  EXPECT_EQ(camera_of("somebody_elses").fx, 525.0);
}

TEST_F(Layout, EurocCarriesTheBodyToTheCamera) {
  put_euroc();
  const Sequence sequence = read();
  EXPECT_EQ(sequence.images[1], "mav0/cam0/data/b.png");
  EXPECT_EQ(sequence.camera.width, 752);
  EXPECT_EQ(lens_name(sequence.camera.lens), "radtan");
  ASSERT_TRUE(sequence.truth[0] && sequence.truth[1]);
  EXPECT_TRUE(sequence.truth[0]->position.isApprox(Eigen::Vector3d(1.5, 2, 3)));
  // The camera's x axis is the body's y axis.
  const Eigen::Vector3d x = sequence.truth[0]->orientation * Eigen::Vector3d::UnitX();
  EXPECT_TRUE(x.isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_NEAR(sequence.truth[1]->position.x(), 2.3, 1e-6);  // 1.06 s: 1.5, 1.11 s: 2.5
}

TEST_F(Layout, KittiOdometryMovesTheTruthToItsCamera) {
  put_kitti();
  const Sequence sequence = read();
  EXPECT_EQ(sequence.images[1], "image_2/000001.png");
  EXPECT_EQ(sequence.camera.width, 0);  // only the images tell
  std::filesystem::remove(folder_.path() / "image_2/000001.png");
  EXPECT_EQ(images_present(sequence), (std::vector<bool>{true, false}));
  ASSERT_TRUE(sequence.truth[0] && sequence.truth[1]);
  // x_2 = x_0 + 0.1: camera 2 stands 0.1 m to the left of camera 0.
  EXPECT_TRUE(sequence.truth[0]->position.isApprox(Eigen::Vector3d(-0.1, 0, 0)));
  EXPECT_TRUE(sequence.truth[1]->position.isApprox(Eigen::Vector3d(0.1, 0, 5)));
  EXPECT_FALSE(sequence.prior || sequence.motion);
}

TEST_F(Layout, KittiWithoutItsFirstImageHasTheEndingOfTheOthers) {
  put_kitti();
  std::filesystem::remove(folder_.path() / "image_2/000000.png");
  std::filesystem::remove(folder_.path() / "image_2/000001.png");
  put("image_2/000001.jpg", "");
  EXPECT_EQ(read().images[0], "image_2/000000.jpg");
}

TEST_F(Layout, KittiRawFromGps) {
  const std::string drive = "image_00/";
  put(drive + "timestamps.txt", "2011-09-26 13:02:25.000000000\n2011-09-26 13:02:26.000000000\n");
  put("calib_cam_to_cam.txt",
      "S_rect_00: 1242 375\nR_rect_00: 1 0 0 0 1 0 0 0 1\nP_rect_00: 720 0 600 0 0 720 170 0 0 0 1 "
      "0\n");
  // Camera axes from the unit's (x forward, y left, z up).
  const std::string axes = "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 0 0\n";
  put("calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: 0 0 0\n");
  put("calib_velo_to_cam.txt", axes);
  put("oxts/timestamps.txt", "2011-09-26 13:02:25.000000000\n2011-09-26 13:02:26.000000000\n");
  const std::string rest = " 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n";
  const double step = 10.0 / 6378137.0 * 180.0 / std::numbers::pi;  // 10 m to the east
  put("oxts/data/0000000000.txt", "0 8 100 0 0 0" + rest);
  put("oxts/data/0000000001.txt", "0 " + std::to_string(8.0 + step) + "00 100 0 0 0" + rest);
  const Sequence sequence = read();
  EXPECT_EQ(sequence.images[1], "image_00/data/0000000001.png");
  EXPECT_EQ(sequence.camera.height, 375);
  EXPECT_EQ(sequence.frames[1].timestamp - sequence.frames[0].timestamp, 1.0);
  ASSERT_TRUE(sequence.truth[1].has_value());
  EXPECT_NEAR(sequence.truth[1]->position.z(), 10.0, 0.1);  // yaw 0 looks east
  EXPECT_NEAR(sequence.truth[1]->position.x(), 0.0, 1e-6);
}

TEST_F(Layout, WhatIsWrongIsNamed) {
  EXPECT_THAT(refusal(), HasSubstr("not a sequence of images"));
  put_kitti();
  put("times.txt", "0.1\n0\n");
  EXPECT_THAT(refusal(), HasSubstr("times.txt:2: timestamp"));
  put("times.txt", "");
  EXPECT_THAT(refusal(), HasSubstr("times.txt: names no image"));
  put("times.txt", "0\n0.1\n0.2\n");
  EXPECT_THAT(refusal(), HasSubstr("fewer poses than times"));
  put("calib.txt", "P0: 1\n");
  EXPECT_THAT(refusal(), HasSubstr("no row 'P2:'"));
  put("calib.txt", "P2: 1 2\n");
  EXPECT_THAT(refusal(), HasSubstr("calib.txt:1: expected 13 fields, found 3"));
}

TEST_F(Layout, UnreadableFolder) {
  EXPECT_THROW(read_images(folder_.path() / "nowhere"), InputError);
  put("file");
  EXPECT_THROW(read_images(folder_.path() / "file"), InputError);
}

TEST_F(Layout, RunningAnEstimatorOnImagesSaysWhatToDo) {
  put_kitti();
  EXPECT_THAT(test::refusal_of([&] { read_sequence(folder_.path()); }), HasSubstr("slammot track"));
}

}  // namespace
}  // namespace slammot
