// Images of a smooth texture under a known warp.
#pragma once

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

#include "frontend/features/patch.h"

namespace slammot {

// A number in [0, 1) for each place of a lattice.
inline double lattice(int x, int y) {
  auto h = static_cast<std::uint32_t>(x) * 374761393u + static_cast<std::uint32_t>(y) * 668265263u;
  h = (h ^ (h >> 13)) * 1274126177u;
  return (h ^ (h >> 16)) / 4294967296.0;
}

// Smooth texture without a period: noise on a lattice of 7 pixels.
inline double texture(double x, double y) {
  x /= 7.0;
  y /= 7.0;
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const auto ease = [](double t) { return t * t * (3.0 - 2.0 * t); };
  const double a = ease(x - i), b = ease(y - j);
  const double above = (1.0 - a) * lattice(i, j) + a * lattice(i + 1, j);
  const double below = (1.0 - a) * lattice(i, j + 1) + a * lattice(i + 1, j + 1);
  return 255.0 * ((1.0 - b) * above + b * below);
}

// The texture under x_texture = A^-1 (x_image - t).
inline cv::Mat textured(const cv::Size& size, const Warp& warp) {
  cv::Mat image(size, CV_8U);
  const Eigen::Matrix2d inverse = warp.A.inverse();
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const Eigen::Vector2d p = inverse * (Eigen::Vector2d(u, v) - warp.t);
      image.at<uchar>(v, u) = cv::saturate_cast<uchar>(texture(p.x(), p.y()));
    }
  }
  return image;
}

}  // namespace slammot
