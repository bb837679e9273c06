#include "models/points/scale.h"

#include <cmath>

namespace slammot {

Eigen::Vector3d scaled(const PointFunctions& point, const Eigen::Vector3d& y, double t) {
  const PointRay ray = point.ray(y);
  return point.of(ray.direction, ray.inverse_depth * std::exp(-t), y);
}

Eigen::Matrix3d scaled_jacobian(const PointFunctions& point, const Eigen::Vector3d& y, double t) {
  const PointRay ray = point.ray(y);
  const double shrunk = std::exp(-t);
  const Matrix34d J = point.of_jacobian(ray.direction, ray.inverse_depth * shrunk);
  return J.leftCols<3>() * ray.J_direction + J.col(3) * (shrunk * ray.J_inverse_depth);
}

Eigen::Vector3d along_scale(const PointFunctions& point, const Eigen::Vector3d& y) {
  const PointRay ray = point.ray(y);
  return -ray.inverse_depth * point.of_jacobian(ray.direction, ray.inverse_depth).col(3);
}

}  // namespace slammot
