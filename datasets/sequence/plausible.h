// What no camera and no clock does: the reason, or nothing. Every reader asks here.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>

#include "models/camera.h"

namespace slammot {

using Fault = std::optional<std::string>;

// Focal lengths from 0.05 to 100 image sizes; the principal point, like a measurement, at most one
// image size outside the image. A camera of unknown size (0, 0) needs a positive focal length only.
Fault camera_fault(const Camera& camera);
Fault pixel_fault(const Camera& camera, const Eigen::Vector2d& pixel);

// Units in which others write times.
struct TimeUnit {
  const char* name;
  double per_second;
};
inline constexpr std::array<TimeUnit, 3> kTimeUnits{{{"milliseconds (seconds times 1000)", 1e3},
                                                     {"microseconds (seconds times 1e6)", 1e6},
                                                     {"nanoseconds (seconds times 1e9)", 1e9}}};
// The first in which `value` is at most `largest` seconds; the last if none is.
const TimeUnit& unit_of_time(double value, double largest);

Fault time_fault(double time);                  // [s]
Fault order_fault(double before, double time);  // which must increase
// The same of frames, which at least a nanosecond and a thousand steps of a double lie between:
// seconds since 1970 are told apart to a quarter of a millisecond.
Fault step_fault(double before, double time);

// Recorded quaternions have few digits; one whose length differs from 1 by more than 1% is a
// mistake.
Fault quaternion_fault(const Eigen::Quaterniond& q);

bool is_rotation(const Eigen::Matrix3d& R);

}  // namespace slammot
