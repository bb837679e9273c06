// The radial-tangential lens is OpenCV's, with five coefficients in the same order.
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <random>

#include "models/camera.h"

namespace slammot {
namespace {

TEST(Lens, RadtanIsOpenCvs) {
  // TUM's freiburg1 and freiburg2.
  const std::vector<std::vector<double>> lenses = {{0.2624, -0.9531, -0.0054, 0.0026, 1.1633},
                                                   {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> slope(-0.6, 0.6);
  for (const std::vector<double>& distortion : lenses) {
    const Camera camera{640, 480, 517.3, 516.5, 318.6, 255.3, make_lens("radtan", distortion)};
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

}  // namespace
}  // namespace slammot
