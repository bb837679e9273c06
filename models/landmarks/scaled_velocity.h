// Scaled velocity: modified polar coordinates (Aidala & Hammel 1983) carried to SLAM (DESIGN 4):
// x = (y, u), u = rho v [1/s], v in W.
//
// Prediction: g = G + u dt; G' = g/|g|; rho' = rho/|g|; u' = u/|g|. Nothing is divided by rho, and
// the bearing rate is linear in (u, rho).
#pragma once

#include "models/landmarks/landmark.h"

namespace slammot {

template <PointParametrisation P>
struct ScaledVelocity {
  using Point = P;
  static constexpr std::string_view kName = "scaled_velocity";
  static constexpr std::string_view kDescription =
      "velocity times inverse depth: modified polar coordinates";
  static constexpr int kMotion = 3;
  static constexpr bool kMotionInMetres = false;

  static double rho(const Vector6d& x) { return P::inverse_depth(Eigen::Vector3d(x.head<3>())); }

  template <typename T>
  static Vector6<T> predict(const Vector6<T>& x, double dt) {
    const Vector3<T> y = x.template head<3>(), u = x.template tail<3>();
    const Vector3<T> g = P::direction(y) + u * T(dt);
    const T n = g.norm();
    Vector6<T> next;
    next << P::of(g, T(P::inverse_depth(y) / n), y), u / n;
    return next;
  }

  static Matrix6d predict_jacobian(const Vector6d& x, double dt) {
    const Eigen::Vector3d y = x.head<3>(), u = x.tail<3>();
    const Eigen::Vector3d g = P::direction(y) + u * dt;
    Matrix36d J_g_x;
    J_g_x << P::direction_jacobian(y), dt * Eigen::Matrix3d::Identity();
    const double n = g.norm();
    const Eigen::Matrix<double, 1, 6> g_J = g.transpose() * J_g_x;
    Eigen::Matrix<double, 1, 6> J_next_x = -rho(x) / (n * n * n) * g_J;
    J_next_x.head<3>() += P::inverse_depth_jacobian(y) / n;
    Matrix6d F;
    F << moved_jacobian<P>(g, rho(x) / n, J_g_x, J_next_x), -u / (n * n * n) * g_J;
    F.bottomRightCorner<3, 3>().diagonal().array() += 1.0 / n;
    return F;
  }

  static Matrix6d metric_noise_root(const LandmarkPrior& prior, double dt) {
    return acceleration_noise_root(prior.acceleration, dt);
  }
  // u = rho v: moving the point changes rho and with it u, hence the coupling.
  static Matrix6d noise_jacobian(const Vector6d& x) {
    const Eigen::Vector3d y = x.head<3>();
    Matrix6d J = Matrix6d::Zero();
    J.topLeftCorner<3, 3>() = noise_jacobian_static<P>(y);
    J.bottomLeftCorner<3, 3>() = -rho(x) * x.tail<3>() * P::direction(y).transpose();
    J.bottomRightCorner<3, 3>().diagonal().setConstant(rho(x));
    return J;
  }

  static Eigen::Vector3d velocity(const Vector6d& x) { return x.tail<3>() / rho(x); }
  static Matrix36d velocity_jacobian(const Vector6d& x) {
    Matrix36d J = Matrix36d::Zero();
    const Eigen::Vector3d y = x.head<3>();
    J.leftCols<3>() = -x.tail<3>() / (rho(x) * rho(x)) * P::inverse_depth_jacobian(y);
    J.rightCols<3>().diagonal().setConstant(1.0 / rho(x));
    return J;
  }
  static Eigen::Vector3d motion_of(const Eigen::Vector3d& y, const Eigen::Vector3d& v) {
    return P::inverse_depth(y) * v;
  }
  static double density_scale(const Vector6d& x) { return std::abs(rho(x) * rho(x) * rho(x)); }
  static Eigen::Vector3d prior_sigmas(const LandmarkPrior& prior) {
    const double rho = std::hypot(prior.inverse_depth, prior.inverse_depth_sigma, prior.mean_sigma);
    // rho is the root mean square, as stated before any learning.
    return Eigen::Vector3d::Constant(rho * prior.velocity_sigma());
  }
};

}  // namespace slammot
