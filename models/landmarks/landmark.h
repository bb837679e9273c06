// What a model of a possibly moving landmark must provide, and what such models have in common.
//
// The state of a free (unknown or moving) landmark is x = (y, w): y = (theta, phi, rho) as in
// inverse_depth.h, and three numbers w that say how it moves, w = 0 meaning that it is at rest.
// Estimators are templates over this concept; a model is one file and one row of landmark_models.h.
#pragma once

#include <Eigen/Cholesky>
#include <concepts>

#include "models/camera_motion.h"
#include "models/inverse_depth.h"
#include "models/measurement.h"

namespace slammot {

template <typename T>
using Vector6 = Eigen::Matrix<T, 6, 1>;
using Matrix36d = Eigen::Matrix<double, 3, 6>;

template <typename M>
concept LandmarkModel = requires(const Vector6d& x, const Eigen::Vector3d& v, double dt,
                                 const LandmarkPrior& prior) {
  { M::kName } -> std::convertible_to<std::string_view>;
  // x after dt at constant velocity, thesis (2.5), and its Jacobian.
  { M::predict(x, dt) } -> std::convertible_to<Vector6d>;
  { M::predict_jacobian(x, dt) } -> std::convertible_to<Matrix6d>;
  // d x / d(position, velocity in W) at x: carries acceleration noise from metres into the state.
  { M::noise_jacobian(x) } -> std::convertible_to<Matrix6d>;
  // Velocity in W [m/s] and its Jacobian; not finite where rho = 0 makes it so.
  { M::velocity(x) } -> std::convertible_to<Eigen::Vector3d>;
  { M::velocity_jacobian(x) } -> std::convertible_to<Matrix36d>;
  // w of a landmark at y with the velocity v in W.
  { M::motion_of(v, v) } -> std::convertible_to<Eigen::Vector3d>;
  // |dw/dv| at rest: turns a density of w into a density of v.
  { M::density_scale(x) } -> std::convertible_to<double>;
  // The prior standard deviation of each component of w, thesis (2.6).
  { M::prior_sigma(prior) } -> std::convertible_to<double>;
};

// d(theta, phi, rho) / d(position in W), per metre, at y: moving the point by p moves the scaled
// ray G by rho p, and rho' = rho / |G + rho p|.
inline Eigen::Matrix3d noise_jacobian_static(const Eigen::Vector3d& y) {
  const double rho = y.z();
  const Eigen::Vector3d G = direction(y.x(), y.y());
  Eigen::Matrix3d J;
  J << rho * angles_jacobian(G), -rho * rho * G.transpose();
  return J;
}

// G with Q = G G' for one step of a free landmark, 6x6: Wiener noise of acceleration sigma_a
// [m/s^2] per axis in (position, velocity), carried into x at the predicted state. At rho = 0 the
// noise of a bearing vanishes, so that Q is singular there; neither the filter nor the smoother
// inverts it.
template <LandmarkModel M>
Matrix6d landmark_noise_root(const Vector6d& predicted, double sigma_a, double dt) {
  const Eigen::Matrix2d L = white_noise_pattern(dt).llt().matrixL();
  Matrix6d L_metric = Matrix6d::Zero();
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j <= i; ++j) {
      L_metric.block<3, 3>(3 * i, 3 * j).diagonal().setConstant(sigma_a * L(i, j));
    }
  }
  return M::noise_jacobian(predicted) * L_metric;
}

}  // namespace slammot
