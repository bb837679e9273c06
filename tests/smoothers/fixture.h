// What the tests of smoothers/ share: a camera, and where it is.
#pragma once

#include "models/camera.h"
#include "models/camera_state.h"

namespace slammot::test {

inline Camera pinhole() { return {640, 480, 385.0, 385.0, 319.5, 239.5, PinholeLens{}}; }

inline CameraState camera_at(double x, double turn) {
  CameraState c;
  c.position = {x, 0.1 * x, 0.0};
  c.orientation = exp_so3(Eigen::Vector3d(0.0, turn, 0.02));
  c.velocity = {1.0, 0.1, 0.0};
  c.angular_velocity = {0.0, turn, 0.0};
  return c;
}

}  // namespace slammot::test
