// The thesis's dynamic inverse depth parametrization (2.3): x = (y, v), v in W [m/s].
//
// Prediction, (2.5): a + G'/rho' = a + G/rho + v dt. Multiplied by rho it needs no division:
//   g = G + rho v dt,   G' = g / |g|,   rho' = rho / |g|,   v' = v.
#pragma once

#include "models/landmarks/landmark.h"

namespace slammot {

template <PointParametrisation P>
struct DynamicInverseDepth {
  using Point = P;
  static constexpr std::string_view kName = "dynamic_inverse_depth";
  static constexpr std::string_view kDescription =
      "the thesis: position and velocity in metres (2.3)";
  static constexpr int kMotion = 3;
  static constexpr bool kMotionInMetres = true;

  template <typename T>
  static Vector6<T> predict(const Vector6<T>& x, double dt) {
    const Vector3<T> y = x.template head<3>(), v = x.template tail<3>();
    const T rho = P::inverse_depth(y);
    const Vector3<T> g = P::direction(y) + rho * v * T(dt);
    Vector6<T> next;
    next << P::of(g, T(rho / g.norm()), y), v;
    return next;
  }

  static Matrix6d predict_jacobian(const Vector6d& x, double dt) {
    const Eigen::Vector3d y = x.head<3>(), v = x.tail<3>();
    const double rho = P::inverse_depth(y);
    const Eigen::RowVector3d J_rho_y = P::inverse_depth_jacobian(y);
    const Eigen::Vector3d g = P::direction(y) + rho * v * dt;
    Matrix36d J_g_x;
    J_g_x << P::direction_jacobian(y) + v * dt * J_rho_y, rho * dt * Eigen::Matrix3d::Identity();
    const double n = g.norm();
    Eigen::Matrix<double, 1, 6> J_next_x = -rho / (n * n * n) * g.transpose() * J_g_x;
    J_next_x.head<3>() += J_rho_y / n;
    Matrix6d F = Matrix6d::Identity();
    F.topRows<3>() = moved_jacobian<P>(g, rho / n, J_g_x, J_next_x);
    return F;
  }

  static Matrix6d metric_noise_root(const LandmarkPrior& prior, double dt) {
    return acceleration_noise_root(prior.acceleration, dt);
  }
  static Matrix6d noise_jacobian(const Vector6d& x) {
    Matrix6d J = Matrix6d::Identity();
    J.topLeftCorner<3, 3>() = noise_jacobian_static<P>(x.head<3>());
    return J;
  }

  static Eigen::Vector3d velocity(const Vector6d& x) { return x.tail<3>(); }
  static Matrix36d velocity_jacobian(const Vector6d&) {
    Matrix36d J = Matrix36d::Zero();
    J.rightCols<3>().setIdentity();
    return J;
  }
  static Eigen::Vector3d motion_of(const Eigen::Vector3d& /*y*/, const Eigen::Vector3d& v) {
    return v;
  }
  static double density_scale(const Vector6d&) { return 1.0; }
  static Eigen::Vector3d prior_sigmas(const LandmarkPrior& prior) {
    return Eigen::Vector3d::Constant(prior.velocity_sigma());
  }
};

}  // namespace slammot
