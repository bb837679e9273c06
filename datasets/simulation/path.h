// A camera on a path in a horizontal plane (y down), with a heading about the y axis: heading 0
// looks along +z, heading pi/2 along +x.
#pragma once

#include "models/camera_state.h"

namespace slammot {

struct PathPoint {
  Eigen::Vector3d position;  // W [m]
  double heading = 0.0;      // of the tangent [rad]
  double speed = 0.0;        // [m/s]
  double turn_rate = 0.0;    // of the heading [rad/s]
};

// Looks along the tangent, turned by `view` [rad] to the right of it.
CameraState camera_on_path(const PathPoint& point, double view);

Eigen::Vector3d heading_vector(double heading);

}  // namespace slammot
