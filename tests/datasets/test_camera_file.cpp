// Calibrations as other programs write them become the same camera, or are refused by name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/camera/camera_file.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

CameraFile read(const std::string& text) { return read_camera_file("c.yaml", text); }
std::string refusal(const std::string& text) {
  return test::refusal_of([&] { read(text); });
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  return text.replace(text.find(from), from.size(), to);
}

constexpr char kKalibr[] =
    "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [-0.283, 0.0739, 0.00019, 1.76e-05]\n"
    "  distortion_model: radtan\n  intrinsics: [458.654, 457.296, 367.215, 248.375]\n"
    "  resolution: [752, 480]\n  rostopic: /cam0/image_raw\n";
constexpr char kEuroc[] =
    "sensor_type: camera\nresolution: [752, 480]\ncamera_model: pinhole\n"
    "intrinsics: [458.654, 457.296, 367.215, 248.375]\ndistortion_model: radial-tangential\n"
    "distortion_coefficients: [-0.283, 0.0739, 0.00019, 1.76e-05]\n";
constexpr char kOpencv[] =
    "%YAML:1.0\n---\nimage_width: 752\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n"
    "   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 458.654, 0., 367.215, 0., 457.296, 248.375, 0., 0., 1. ]\n"
    "distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 4\n   dt: d\n"
    "   data: [ -0.283, 0.0739, 0.00019, 1.76e-05 ]\n";
constexpr char kRos[] =
    "image_width: 752\nimage_height: 480\ncamera_name: cam0\ndistortion_model: plumb_bob\n"
    "camera_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [458.654, 0, 367.215, 0, 457.296, 248.375, 0, 0, 1]\n"
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n"
    "  data: [-0.283, 0.0739, 0.00019, 1.76e-05, 0]\n";
constexpr char kRosMessage[] =
    "header: {frame_id: cam0}\nheight: 480\nwidth: 752\ndistortion_model: plumb_bob\n"
    "d: [-0.283, 0.0739, 0.00019, 1.76e-05, 0.0]\n"
    "k:\n- 458.654\n- 0.0\n- 367.215\n- 0.0\n- 457.296\n- 248.375\n- 0.0\n- 0.0\n- 1.0\n---\n";
constexpr char kOrbSlam[] =
    "%YAML:1.0\n\nCamera.type: \"PinHole\"\nCamera.fx: 458.654\nCamera.fy: 457.296\n"
    "Camera.cx: 367.215\nCamera.cy: 248.375\n\nCamera.k1: -0.283\nCamera.k2: 0.0739\n"
    "Camera.p1: 0.00019\nCamera.p2: 1.76e-05\nCamera.width: 752\nCamera.height: 480\n"
    "Camera.fps: 20.0\nCamera.RGB: 1\n";

TEST(CameraFile, OfOtherPrograms) {
  const std::string sequence =
      "camera: {model: radtan, width: 752, height: 480, fx: 458.654, fy: 457.296, cx: 367.215, "
      "cy: 248.375, distortion: [-0.283, 0.0739, 0.00019, 1.76e-05]}\n";
  std::string third = kOrbSlam;
  for (const char* key : {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"}) {
    third = replaced(third, std::string("Camera.") + key, std::string("Camera1.") + key);
  }
  for (const std::string& text :
       {std::string(kKalibr), std::string(kEuroc), std::string(kOpencv), std::string(kRos),
        std::string(kRosMessage), std::string(kOrbSlam), third, sequence}) {
    SCOPED_TRACE(text);
    const Camera camera = read(text).camera;
    EXPECT_EQ(lens_name(camera.lens), "radtan");
    EXPECT_EQ(camera.width, 752);
    EXPECT_EQ(camera.height, 480);
    EXPECT_EQ(camera.fx, 458.654);
    EXPECT_EQ(camera.fy, 457.296);
    EXPECT_EQ(camera.cx, 367.215);
    EXPECT_EQ(camera.cy, 248.375);
    EXPECT_THAT(lens_distortion(camera.lens), ElementsAre(-0.283, 0.0739, 0.00019, 1.76e-05, 0.0));
  }
}

TEST(CameraFile, OfOtherLenses) {
  const auto lens = [](const std::string& text) { return lens_name(read(text).camera.lens); };
  EXPECT_EQ(lens(replaced(kKalibr, "radtan", "equidistant")), "equidistant");
  EXPECT_EQ(lens(replaced(kOpencv, "image_width", "fisheye_model: 1\nimage_width")), "equidistant");
  EXPECT_EQ(lens(replaced(kOpencv, "1.76e-05 ]", "1.76e-05, 0.1, 0.2, 0.3, 0.4 ]")), "rational");
  EXPECT_EQ(lens(replaced(kRos, "plumb_bob", "rational_polynomial")), "rational");
  EXPECT_EQ(lens(replaced(kOrbSlam, "PinHole", "KannalaBrandt8")), "equidistant");
  const std::string sphere =
      replaced(replaced(kKalibr, "pinhole", "ds"), "[458", "[-0.2, 0.6, 458");
  const Camera camera = read(replaced(replaced(sphere, "radtan", "none"),
                                      "[-0.283, 0.0739, 0.00019, 1.76e-05]", "[]"))
                            .camera;
  EXPECT_EQ(camera.fx, 458.654);
  EXPECT_THAT(lens_distortion(camera.lens), ElementsAre(-0.2, 0.6));
}

TEST(CameraFile, TheFirstOfSeveralIsNamedAndASizeMayBeMissing) {
  EXPECT_EQ(read(kKalibr).form, "kalibr");
  EXPECT_THAT(read(std::string(kKalibr) + "cam1: {}\n").form,
              HasSubstr("the first of its cameras"));
  EXPECT_THAT(read(std::string(kOrbSlam) + "Camera2.fx: 400\n").form,
              HasSubstr("the first of its cameras"));
  EXPECT_EQ(
      read(replaced(replaced(kOrbSlam, "Camera.width", "w"), "Camera.height", "h")).camera.width,
      0);
}

TEST(CameraFile, WhatIsNotKnownIsRefusedByName) {
  EXPECT_THAT(
      refusal(replaced(kKalibr, "1.76e-05]", "1.76e-05, 0.1, 0.2, 0.3, 0.4]")),
      HasSubstr("c.yaml:4: camera model 'radtan' takes at most 5 distortion coefficients, not "
                "8: the model 'rational' takes 8"));
  EXPECT_THAT(refusal(replaced(kOrbSlam, "Camera.fps", "Camera.k4: 0.1\nCamera.fps")),
              HasSubstr("rational"));
  EXPECT_THAT(refusal(replaced(replaced(kKalibr, "pinhole", "omni"), "[458", "[1.2, 458")),
              HasSubstr("unknown camera model 'omni' (known: pinhole"));
  EXPECT_THAT(refusal(replaced(kKalibr, "radtan", "fov")), HasSubstr("unknown camera model 'fov'"));
  EXPECT_THAT(refusal(replaced(kOpencv, "458.654, 0.", "458.654, 0.5")),
              HasSubstr("'camera_matrix' has a skew"));
  EXPECT_THAT(refusal(replaced(kRos, "0, 0, 1]", "367, 248, 1]")), HasSubstr("no camera matrix"));
  EXPECT_THAT(refusal(replaced(kOpencv, "image_width", "w")),
              HasSubstr("'image_width' is missing"));
  EXPECT_THAT(refusal("M1: [1, 2]\n"), HasSubstr("no calibration: expected model, width, height"));
  EXPECT_THAT(refusal("fx: 100\n"), HasSubstr("'model' is missing"));
}

}  // namespace
}  // namespace slammot
