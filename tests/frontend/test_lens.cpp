// The radial-tangential lens is OpenCV's, with five or eight coefficients in the same order.
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <random>

#include "models/camera.h"

namespace slammot {
namespace {

TEST(Lens, RadtanIsOpenCvs) {
  // TUM's freiburg1 and freiburg2, and one with a denominator.
  const std::vector<std::vector<double>> lenses = {
      {0.2624, -0.9531, -0.0054, 0.0026, 1.1633},
      {0.2312, -0.7849, -0.0033, -0.0001, 0.9172},
      {0.52, -2.61, 3e-4, -2e-4, 1.49, 0.40, -2.43, 1.42}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> slope(-0.6, 0.6);
  for (const std::vector<double>& distortion : lenses) {
    const Camera camera{640,
                        480,
                        517.3,
                        516.5,
                        318.6,
                        255.3,
                        make_lens(distortion.size() == 5 ? "radtan" : "rational", distortion)};
    const cv::Matx33d K(camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0);
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector3d ray(slope(random), slope(random), 1.0);
      std::vector<cv::Point2d> expected;
      cv::projectPoints(std::vector<cv::Point3d>{{ray.x(), ray.y(), ray.z()}}, cv::Vec3d(0, 0, 0),
                        cv::Vec3d(0, 0, 0), K, distortion, expected);
      const auto projection = camera.project(ray);
      ASSERT_TRUE(projection);
      EXPECT_NEAR(projection->pixel.x(), expected[0].x, 1e-9);
      EXPECT_NEAR(projection->pixel.y(), expected[0].y, 1e-9);
    }
  }
}

std::string refusal_of(std::string_view name, const std::vector<double>& distortion) {
  try {
    make_lens(name, distortion);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

// Other programs' names, the zeros that they write, and never the first five of eight.
TEST(Lens, NamesAndCounts) {
  for (const auto& [name, ours] : {std::pair{"plumb_bob", "radtan"},
                                   {"radial-tangential", "radtan"},
                                   {"fisheye", "equidistant"},
                                   {"rational_polynomial", "rational"},
                                   {"ds", "double_sphere"},
                                   {"none", "pinhole"}}) {
    EXPECT_EQ(lens_name(make_lens(name, {})), ours);
  }
  const std::vector<double> padded = {-0.283, 0.0739, 1.9e-4, 1.76e-5, 0.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(lens_distortion(make_lens("plumb_bob", padded)).size(), 5u);
  std::vector<double> eight = padded;
  eight.back() = 1.42;
  EXPECT_NE(refusal_of("radtan", eight).find("the model 'rational' takes 8"), std::string::npos);
  EXPECT_NE(refusal_of("pinhole", padded).find("at most 0"), std::string::npos);
  EXPECT_NE(refusal_of("fov", {}).find("radtan (also plumb_bob"), std::string::npos);
}

}  // namespace
}  // namespace slammot
