#include "datasets/sequence/plausible.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace slammot {
namespace {

constexpr double kShortestFocal = 0.05, kLongestFocal = 100.0;  // [image sizes]
constexpr int kLargestImage = 100000;                           // [px] along a side
constexpr double kLargestCoefficient = 1000.0;
constexpr double kLatest = 1e11;        // [s], three thousand years
constexpr double kShortestStep = 1e-9;  // [s]
constexpr double kSteps = 1000.0;       // of a double
constexpr double kLengthTolerance = 1e-2;

// At most one size outside, on either side.
bool is_near(double x, int size) { return x >= -size && x <= 2.0 * size; }

}  // namespace

Fault camera_fault(const Camera& camera) {
  if (!(camera.fx > 0.0) || !(camera.fy > 0.0)) return "the focal length is not greater than zero";
  if (camera.width == 0 && camera.height == 0) return std::nullopt;
  if (camera.width < 1 || camera.height < 1) return "the image has no size";
  const int longer = std::max(camera.width, camera.height);
  if (longer > kLargestImage) return fmt::format("no image is {} px wide or high", longer);
  for (const double f : {camera.fx, camera.fy}) {
    if (f >= kShortestFocal * longer && f <= kLongestFocal * longer) continue;
    return fmt::format("a focal length of {} px is not plausible for {} x {} px", f, camera.width,
                       camera.height);
  }
  if (!is_near(camera.cx, camera.width) || !is_near(camera.cy, camera.height)) {
    return fmt::format("the principal point {}, {} is far outside the image", camera.cx, camera.cy);
  }
  for (const double k : lens_distortion(camera.lens)) {
    if (std::abs(k) > kLargestCoefficient) return fmt::format("no lens has a coefficient {}", k);
  }
  return std::nullopt;
}

Fault pixel_fault(const Camera& camera, const Eigen::Vector2d& pixel) {
  if (is_near(pixel.x(), camera.width) && is_near(pixel.y(), camera.height)) return std::nullopt;
  return fmt::format("pixel {}, {} is more than one image size outside the image of {} x {} px",
                     pixel.x(), pixel.y(), camera.width, camera.height);
}

Fault time_fault(double time) {
  if (std::abs(time) <= kLatest) return std::nullopt;
  return fmt::format("a time of {} s is not plausible; are these {}?", time,
                     unit_of_time(time, kLatest).name);
}

const TimeUnit& unit_of_time(double value, double largest) {
  return *std::ranges::find_if(kTimeUnits, [&](const TimeUnit& unit) {
    return std::abs(value) / unit.per_second <= largest || &unit == &kTimeUnits.back();
  });
}

Fault order_fault(double before, double time) {
  if (time > before) return time_fault(time);
  return fmt::format("timestamp {} does not follow {}: they must increase{}", time, before,
                     time == before ? "; are times repeated or rounded?" : "");
}

Fault step_fault(double before, double time) {
  if (Fault fault = order_fault(before, time)) return fault;
  const double unit = std::nextafter(std::abs(time), INFINITY) - std::abs(time);
  if (time - before < std::max(kShortestStep, kSteps * unit)) {
    return fmt::format("timestamp {} follows {} too closely for its digits", time, before);
  }
  return std::nullopt;
}

Fault quaternion_fault(const Eigen::Quaterniond& q) {
  const double length = q.norm();
  if (length < 1e-6) return "the quaternion has length zero";
  if (std::abs(length - 1.0) <= kLengthTolerance) return std::nullopt;
  return fmt::format("the quaternion has length {:.4g}, not 1", length);
}

bool is_rotation(const Eigen::Matrix3d& R) {
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-2 && R.determinant() > 0.0;
}

}  // namespace slammot
