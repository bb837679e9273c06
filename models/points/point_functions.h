// The table of point parametrisations (all_points.h adds one): what estimators use of one is
// gathered in a row of functions, so that an estimator is compiled once. Beside it, what follows
// from direction and inverse depth alone.
#pragma once

#include <span>
#include <string>

#include "models/points/point.h"

namespace slammot {

// G and rho at y, with their Jacobians.
struct PointRay {
  Eigen::Vector3d direction;
  double inverse_depth = 0.0;
  Eigen::Matrix3d J_direction;
  Eigen::RowVector3d J_inverse_depth;
};

// As the members of the concept PointParametrisation; `ray` has four of them in one call.
struct PointFunctions {
  std::string_view name;
  std::string_view description;
  bool linear_depth = true;

  PointRay (*ray)(const Eigen::Vector3d& y);
  double (*inverse_depth)(const Eigen::Vector3d& y);
  Eigen::RowVector3d (*inverse_depth_jacobian)(const Eigen::Vector3d& y);
  Eigen::Vector3d (*of)(const Eigen::Vector3d& g, double rho, const Eigen::Vector3d& near);
  Matrix34d (*of_jacobian)(const Eigen::Vector3d& g, double rho);
  bool (*exists)(const Eigen::Vector3d& g, double rho);
};

template <PointParametrisation P>
constexpr PointFunctions point_row() {
  using Eigen::Vector3d;
  return {P::kName,
          P::kDescription,
          P::kLinearDepth,
          [](const Vector3d& y) -> PointRay {
            return {P::direction(y), P::inverse_depth(y), P::direction_jacobian(y),
                    P::inverse_depth_jacobian(y)};
          },
          [](const Vector3d& y) -> double { return P::inverse_depth(y); },
          [](const Vector3d& y) -> Eigen::RowVector3d { return P::inverse_depth_jacobian(y); },
          [](const Vector3d& g, double rho, const Vector3d& near) -> Vector3d {
            return P::of(g, rho, near);
          },
          [](const Vector3d& g, double rho) -> Matrix34d { return P::of_jacobian(g, rho); },
          [](const Vector3d& g, double rho) -> bool { return P::exists(g, rho); }};
}

std::span<const PointFunctions> point_table();

// Throws std::invalid_argument for an unknown name.
const PointFunctions& find_point(const std::string& name);

// x_W. Infinite at rho = 0.
Eigen::Vector3d position_world(const PointFunctions& point, const Eigen::Vector3d& anchor,
                               const Eigen::Vector3d& y);

// d position_world / dy; with respect to the anchor it is the identity.
Eigen::Matrix3d position_jacobian(const PointFunctions& point, const Eigen::Vector3d& y);

// y of a point given by its offset d = x_W - a from the anchor, and its Jacobian.
Eigen::Vector3d point_at(const PointFunctions& point, const Eigen::Vector3d& d);
Eigen::Matrix3d point_at_jacobian(const PointFunctions& point, const Eigen::Vector3d& d);

}  // namespace slammot
