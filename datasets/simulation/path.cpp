#include "datasets/simulation/path.h"

#include <cmath>

namespace slammot {

Eigen::Vector3d heading_vector(double heading) {
  return {std::sin(heading), 0.0, std::cos(heading)};
}

CameraState camera_on_path(const PathPoint& point, double view) {
  CameraState camera;
  camera.position = point.position;
  camera.orientation = exp_so3(Eigen::Vector3d((point.heading + view) * Eigen::Vector3d::UnitY()));
  camera.velocity = point.speed * heading_vector(point.heading);
  camera.angular_velocity = point.turn_rate * Eigen::Vector3d::UnitY();
  return camera;
}

}  // namespace slammot
