// The thesis's dynamic inverse depth parametrization (2.3): x = (theta, phi, rho, v), v in W [m/s].
//
// Prediction, (2.5): a + G'/rho' = a + G/rho + v dt. Multiplied by rho it needs no division:
//   g = G + rho v dt,   (theta', phi') = angles of g,   rho' = rho / |g|,   v' = v.
#pragma once

#include "models/landmarks/landmark.h"

namespace slammot {

struct DynamicInverseDepth {
  static constexpr std::string_view kName = "dynamic_inverse_depth";
  static constexpr int kMotion = 3;

  template <typename T>
  static Vector6<T> predict(const Vector6<T>& x, double dt) {
    const T rho = x(2);
    const Vector3<T> v = x.template tail<3>();
    const Vector3<T> g = direction(T(x(0)), T(x(1))) + rho * v * T(dt);
    Vector6<T> y;
    y << angles(g, T(x(0))), rho / g.norm(), v;
    return y;
  }

  static Matrix6d predict_jacobian(const Vector6d& x, double dt) {
    const double rho = x(2);
    const Eigen::Vector3d v = x.tail<3>();
    const Eigen::Vector3d g = direction(x(0), x(1)) + rho * v * dt;
    Eigen::Matrix<double, 3, 6> J_g_x;
    J_g_x << direction_jacobian(x(0), x(1)), v * dt, rho * dt * Eigen::Matrix3d::Identity();
    const double n = g.norm();
    Matrix6d F = Matrix6d::Identity();
    F.topRows<2>() = angles_jacobian(g) * J_g_x;
    F.row(2) = -rho / (n * n * n) * g.transpose() * J_g_x;
    F(2, 2) += 1.0 / n;
    return F;
  }

  static Matrix6d metric_noise_root(const LandmarkPrior& prior, double dt) {
    return acceleration_noise_root(prior.acceleration, dt);
  }
  static Matrix6d noise_jacobian(const Vector6d& x) {
    Matrix6d J = Matrix6d::Identity();
    J.topLeftCorner<3, 3>() = noise_jacobian_static(x.head<3>());
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

static_assert(LandmarkModel<DynamicInverseDepth>);

}  // namespace slammot
