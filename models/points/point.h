// What a parametrisation of a point must provide. A landmark's position is three numbers y, seen
// from its anchor a (W), where the camera was when the point was first seen:
//
//   x_W = a + G(y) / rho(y),   G the unit direction (W), rho the inverse depth [1/m]
//
// A parametrisation says what y is, and nothing else knows: landmark models, observation, births
// and priors use G and rho. The anchor is kept apart, because all landmarks born in one frame share
// it exactly. A parametrisation is one file and one entry of all_points.h.
#pragma once

#include <concepts>
#include <string_view>

#include "models/so3.h"

namespace slammot {

using Matrix23d = Eigen::Matrix<double, 2, 3>;
using Matrix32d = Eigen::Matrix<double, 3, 2>;
using Matrix34d = Eigen::Matrix<double, 3, 4>;

template <typename P>
concept PointParametrisation = requires(const Eigen::Vector3d& y, const Eigen::Vector3d& g,
                                        double rho) {
  { P::kName } -> std::convertible_to<std::string_view>;
  { P::kDescription } -> std::convertible_to<std::string_view>;
  // Whether rho is linear in y, so that a Gaussian of rho is one of y.
  { P::kLinearDepth } -> std::convertible_to<bool>;
  // G and rho, templates over their scalar, with their Jacobians.
  { P::direction(y) } -> std::convertible_to<Eigen::Vector3d>;
  { P::direction_jacobian(y) } -> std::convertible_to<Eigen::Matrix3d>;
  { P::inverse_depth(y) } -> std::convertible_to<double>;
  { P::inverse_depth_jacobian(y) } -> std::convertible_to<Eigen::RowVector3d>;
  // y of the point in the direction of g, which has any length, at rho; the y nearest to `near`
  // where there are several. A template too. The Jacobian with respect to (g, rho).
  { P::of(g, rho, y) } -> std::convertible_to<Eigen::Vector3d>;
  { P::of_jacobian(g, rho) } -> std::convertible_to<Matrix34d>;
  // Whether there is such a y, with a Jacobian. Where there is none at rho = 0, smoothers limit
  // the steps of far points.
  { P::exists(g, rho) } -> std::convertible_to<bool>;
};

// d(g/|g|)/dg.
inline Eigen::Matrix3d unit_jacobian(const Eigen::Vector3d& g) {
  const double n = g.norm();
  const Eigen::Vector3d u = g / n;
  return (Eigen::Matrix3d::Identity() - u * u.transpose()) / n;
}

}  // namespace slammot
