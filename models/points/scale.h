// What a change of the world's scale does to a landmark's y, seen from its anchor: a world e^t as
// large has rho e^-t in the same direction. Filter (filters/gauge.h) and smoother
// (smoothers/variables/scale_orbit.h) both keep what they know of the scale along it.
#pragma once

#include "models/points/point_functions.h"

namespace slammot {

// y in a world e^t as large, and d/dy of it.
Eigen::Vector3d scaled(const PointFunctions& point, const Eigen::Vector3d& y, double t);
Eigen::Matrix3d scaled_jacobian(const PointFunctions& point, const Eigen::Vector3d& y, double t);

// n = d scaled / dt at t = 0.
Eigen::Vector3d along_scale(const PointFunctions& point, const Eigen::Vector3d& y);

}  // namespace slammot
