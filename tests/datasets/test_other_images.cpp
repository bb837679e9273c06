// What lies beside the images of camera 0: a second camera where a layout has one, and depths.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/readers/image_reader.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

using ::testing::HasSubstr;
using Names = std::vector<std::string>;

class OtherImages : public ::testing::Test {
 protected:
  void put(const std::string& name, const std::string& text = "") {
    test::write_text(folder_.path() / name, text);
  }
  Sequence read() const {
    Sequence sequence = read_images(folder_.path());
    add_other_images(sequence);
    return sequence;
  }
  std::string refusal() const {
    return test::refusal_of([&] { read(); });
  }
  void put_euroc(const std::string& camera, const std::string& pose, const std::string& images) {
    put("mav0/" + camera + "/data.csv", "#timestamp [ns],filename\n" + images);
    put("mav0/" + camera + "/sensor.yaml",
        "T_BS:\n  data: [" + pose +
            ", 0, 0, 0, 1]\nresolution: [752, 480]\nintrinsics: [458, 457, 367, 248]\n"
            "distortion_model: radial-tangential\ndistortion_coefficients: [-0.28, 0.07, 0, 0]\n");
  }

  test::TemporaryFolder folder_;
};

TEST_F(OtherImages, KittiHasTwoPairs) {
  const std::string calibration =
      "P0: 700 0 600 0 0 700 180 0 0 0 1 0\nP1: 700 0 600 -350 0 700 180 0 0 0 1 0\n"
      "P2: 700 0 600 70 0 700 180 0 0 0 1 0\nP3: 700 0 600 -280 0 700 180 0 0 0 1 0\n";
  put("calib.txt", calibration);
  put("times.txt", "0\n0.1\n");
  put("image_2/000000.png");
  EXPECT_TRUE(read().other_cameras.empty());
  put("image_3/000000.jpg");
  const Sequence colour = read();
  ASSERT_EQ(colour.other_cameras.size(), 1u);
  EXPECT_EQ(colour.other_images[0], (Names{"image_3/000000.jpg", "image_3/000001.jpg"}));
  EXPECT_TRUE(colour.other_cameras[0].t.isApprox(Eigen::Vector3d(0.5, 0, 0)));
  put("image_0/000000.png");
  EXPECT_TRUE(read().other_cameras.empty());  // image_2 is not the other one of image_0
  put("image_1/000000.png");
  const Sequence grey = read();
  EXPECT_EQ(grey.other_images[0][1], "image_1/000001.png");
  EXPECT_TRUE(grey.other_cameras[0].t.isApprox(Eigen::Vector3d(0.5, 0, 0)));
  put("calib.txt", calibration.substr(0, calibration.find("P1")));
  EXPECT_THAT(refusal(), HasSubstr("calib.txt: no row 'P1:'"));
}

TEST_F(OtherImages, KittiRawHasThemToo) {
  put("image_00/timestamps.txt", "2011-09-26 13:02:25.0\n2011-09-26 13:02:26.0\n");
  put("image_01/data/0000000000.png");
  put("calib_cam_to_cam.txt",
      "S_rect_00: 1242 375\nP_rect_00: 720 0 600 0 0 720 170 0 0 0 1 0\n"
      "P_rect_01: 720 0 600 -360 0 720 170 0 0 0 1 0\n");
  const Sequence sequence = read();
  ASSERT_EQ(sequence.other_cameras.size(), 1u);
  EXPECT_EQ(sequence.other_images[0][1], "image_01/data/0000000001.png");
  EXPECT_EQ(sequence.other_cameras[0].lens.width, 1242);
  EXPECT_NEAR(sequence.other_cameras[0].t.x(), 0.5, 1e-12);
}

TEST_F(OtherImages, EurocsSecondCameraStandsInTheFirst) {
  const std::string first = "0, -1, 0, 0.5, 1, 0, 0, 0, 0, 0, 1, 0";
  put_euroc("cam0", first, "1000000000,a.png\n1100000000,b.png\n1200000000,c.png\n");
  // 0.1 m along the body's y axis, which is the first camera's x axis; as the body is turned.
  put_euroc("cam1", "1, 0, 0, 0.5, 0, 1, 0, 0.1, 0, 0, 1, 0",
            "1000000000,d.png\n1150000000,e.png\n1200100000,f.png\n");
  const Sequence sequence = read();
  ASSERT_EQ(sequence.other_cameras.size(), 1u);
  const MountedCamera& other = sequence.other_cameras[0];
  EXPECT_TRUE(other.t.isApprox(Eigen::Vector3d(0.1, 0, 0)));
  const Eigen::Vector3d x = other.R * Eigen::Vector3d::UnitX();
  EXPECT_TRUE(x.isApprox(Eigen::Vector3d(0, -1, 0)));
  EXPECT_EQ(sequence.other_images[0], (Names{"mav0/cam1/data/d.png", "", "mav0/cam1/data/f.png"}));
  put("mav0/cam1/data.csv", "1050000000,e.png\n");
  EXPECT_THAT(refusal(), HasSubstr("cam1/data.csv: no image within 1 ms"));
  put_euroc("cam1", first, "1000000000,d.png\n");
  EXPECT_THAT(refusal(), HasSubstr("cam1/sensor.yaml: the camera stands where the first does"));
  std::filesystem::remove(folder_.path() / "mav0/cam1/sensor.yaml");
  EXPECT_TRUE(read().other_cameras.empty());
}

TEST_F(OtherImages, DepthsOfTumAreTheNearestInTime) {
  put("rgb.txt", "10.0 rgb/a.png\n10.1 rgb/b.png\n10.2 rgb/c.png\n");
  EXPECT_TRUE(read().depth_images.empty());
  put("depth.txt", "# depth maps\n9.99 d/0.png\n10.005 d/1.png\n10.07 d/2.png\n10.19 d/3.png\n");
  const Sequence sequence = read();
  EXPECT_EQ(sequence.depth_images, (Names{"d/1.png", "", "d/3.png"}));
  EXPECT_EQ(sequence.depth_unit, 1.0 / 5000.0);
  EXPECT_EQ(select_frames(sequence, 1, -1, 1).depth_images, (Names{"", "d/3.png"}));
  put("depth.txt", "11 d/0.png\n");
  EXPECT_THAT(refusal(), HasSubstr("depth.txt: no image within 20 ms"));
  put("depth.txt", "11 d/0.png\n10 d/1.png\n");
  EXPECT_THAT(refusal(), HasSubstr("depth.txt:2: timestamp"));
}

}  // namespace
}  // namespace slammot
