#include "models/points/point_functions.h"

#include <array>

#include "models/find_row.h"
#include "models/points/all_points.h"

namespace slammot {
namespace {

template <typename... P>
constexpr std::array<PointFunctions, sizeof...(P)> point_rows(const std::tuple<P...>*) {
  return {point_row<P>()...};
}

constexpr auto kPoints = point_rows(static_cast<const PointParametrisations*>(nullptr));

}  // namespace

std::span<const PointFunctions> point_table() { return kPoints; }

const PointFunctions& find_point(const std::string& name) {
  return find_row(point_table(), name, "point parametrisation");
}

Eigen::Vector3d position_world(const PointFunctions& point, const Eigen::Vector3d& anchor,
                               const Eigen::Vector3d& y) {
  const PointRay ray = point.ray(y);
  return anchor + ray.direction / ray.inverse_depth;
}

Eigen::Matrix3d position_jacobian(const PointFunctions& point, const Eigen::Vector3d& y) {
  const PointRay ray = point.ray(y);
  const double rho = ray.inverse_depth;
  return ray.J_direction / rho - ray.direction * ray.J_inverse_depth / (rho * rho);
}

Eigen::Vector3d point_at(const PointFunctions& point, const Eigen::Vector3d& d) {
  return point.of(d, 1.0 / d.norm(), Eigen::Vector3d::Zero());
}

Eigen::Matrix3d point_at_jacobian(const PointFunctions& point, const Eigen::Vector3d& d) {
  const double n = d.norm();
  const Matrix34d J = point.of_jacobian(d, 1.0 / n);
  return J.leftCols<3>() - J.col(3) * d.transpose() / (n * n * n);
}

}  // namespace slammot
