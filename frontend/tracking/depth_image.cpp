#include "frontend/tracking/depth_image.h"

#include <algorithm>
#include <cmath>

namespace slammot {
namespace {

constexpr double kNearest = 0.05, kFarthest = 1000.0;  // [m], as of the native format
constexpr double kSigma = 0.01;                        // [m]
constexpr double kSigmaOfSquare = 0.005;               // [1/m]
constexpr size_t kLeastValues = 5;

// Those that are there, around a pixel.
std::vector<double> values_around(const cv::Mat& image, const Eigen::Vector2d& pixel) {
  const auto u = static_cast<int>(std::lround(pixel.x()));
  const auto v = static_cast<int>(std::lround(pixel.y()));
  const cv::Rect patch = cv::Rect(u - 1, v - 1, 3, 3) & cv::Rect({0, 0}, image.size());
  std::vector<double> values;
  for (int y = patch.y; y < patch.y + patch.height; ++y) {
    for (int x = patch.x; x < patch.x + patch.width; ++x) {
      if (image.at<ushort>(y, x) > 0) values.push_back(image.at<ushort>(y, x));
    }
  }
  return values;
}

}  // namespace

void measure_depths(const cv::Mat& image, double unit, std::vector<Observation>& z) {
  for (Observation& one : z) {
    std::vector<double> values = values_around(image, one.pixel);
    if (values.size() < kLeastValues) continue;
    std::ranges::sort(values);
    const double depth = unit * values[values.size() / 2];
    if (!(depth >= kNearest && depth <= kFarthest)) continue;
    one.depth = depth;
    one.depth_sigma =
        kSigma + kSigmaOfSquare * depth * depth + unit * (values.back() - values.front()) / 2.0;
  }
}

}  // namespace slammot
