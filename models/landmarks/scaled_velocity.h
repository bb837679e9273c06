// Scaled velocity: modified polar coordinates (Aidala & Hammel 1983) carried to SLAM (DESIGN 4):
// x = (theta, phi, rho, u), u = rho v [1/s], v in W.
//
// Prediction: g = G + u dt; (theta', phi') = angles of g; rho' = rho/|g|; u' = u/|g|. Nothing is
// divided by rho, and the bearing rate is linear in (u, rho).
#pragma once

#include "models/landmarks/landmark.h"

namespace slammot {

struct ScaledVelocity {
  static constexpr std::string_view kName = "scaled_velocity";
  static constexpr int kMotion = 3;

  template <typename T>
  static Vector6<T> predict(const Vector6<T>& x, double dt) {
    const Vector3<T> u = x.template tail<3>();
    const Vector3<T> g = direction(T(x(0)), T(x(1))) + u * T(dt);
    const T n = g.norm();
    Vector6<T> y;
    y << angles(g, T(x(0))), x(2) / n, u / n;
    return y;
  }

  static Matrix6d predict_jacobian(const Vector6d& x, double dt) {
    const Eigen::Vector3d u = x.tail<3>();
    const Eigen::Vector3d g = direction(x(0), x(1)) + u * dt;
    Eigen::Matrix<double, 3, 6> J_g_x;
    J_g_x << direction_jacobian(x(0), x(1)), Eigen::Vector3d::Zero(),
        dt * Eigen::Matrix3d::Identity();
    const double n = g.norm();
    Matrix6d F = Matrix6d::Zero();
    F.topRows<2>() = angles_jacobian(g) * J_g_x;
    F.bottomRows<4>() = -x.tail<4>() / (n * n * n) * (g.transpose() * J_g_x);
    F.bottomRightCorner<4, 4>().diagonal().array() += 1.0 / n;
    return F;
  }

  static Matrix6d metric_noise_root(const LandmarkPrior& prior, double dt) {
    return acceleration_noise_root(prior.acceleration, dt);
  }
  // u = rho v: moving the point changes rho and with it u, hence the coupling.
  static Matrix6d noise_jacobian(const Vector6d& x) {
    const double rho = x(2);
    Matrix6d J = Matrix6d::Zero();
    J.topLeftCorner<3, 3>() = noise_jacobian_static(x.head<3>());
    J.bottomLeftCorner<3, 3>() = -rho * x.tail<3>() * direction(x(0), x(1)).transpose();
    J.bottomRightCorner<3, 3>().diagonal().setConstant(rho);
    return J;
  }

  static Eigen::Vector3d velocity(const Vector6d& x) { return x.tail<3>() / x(2); }
  static Matrix36d velocity_jacobian(const Vector6d& x) {
    Matrix36d J = Matrix36d::Zero();
    J.col(2) = -x.tail<3>() / (x(2) * x(2));
    J.rightCols<3>().diagonal().setConstant(1.0 / x(2));
    return J;
  }
  static Eigen::Vector3d motion_of(const Eigen::Vector3d& y, const Eigen::Vector3d& v) {
    return y.z() * v;
  }
  static double density_scale(const Vector6d& x) { return std::abs(x(2) * x(2) * x(2)); }
  static Eigen::Vector3d prior_sigmas(const LandmarkPrior& prior) {
    const double rho = std::hypot(prior.inverse_depth, prior.inverse_depth_sigma, prior.mean_sigma);
    // rho is the root mean square, as stated before any learning.
    return Eigen::Vector3d::Constant(rho * prior.velocity_sigma());
  }
};

static_assert(LandmarkModel<ScaledVelocity>);

}  // namespace slammot
