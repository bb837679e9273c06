// Dynamic inverse depth with a constant acceleration (the thesis's future work, chapter 5):
// x = (y, v, a), v in W [m/s], a in W [m/s^2].
//
// Prediction, as (2.5) with the displacement s = v dt + a dt^2/2:
//   g = G + rho s,   G' = g / |g|,   rho' = rho / |g|,   v' = v + a dt,   a' = a.
//
// Noise: the acceleration is a Wiener process. `prior.jerk` [m/s^3] is the standard deviation of
// the jerk taken over one step, so that the acceleration has the variance (sigma_j dt)^2 per step,
// as velocities have with `prior.acceleration` in models of constant velocity. At first sight a has
// the standard deviation `prior.acceleration`.
#pragma once

#include "models/landmarks/landmark.h"

namespace slammot {

template <PointParametrisation P>
struct ConstantAcceleration {
  using Point = P;
  static constexpr std::string_view kName = "constant_acceleration";
  static constexpr std::string_view kDescription = "position, velocity and acceleration in metres";
  static constexpr int kMotion = 6;
  static constexpr bool kMotionInMetres = true;

  template <typename T>
  using Vector9 = Eigen::Matrix<T, 9, 1>;
  using Vector9d = Vector9<double>;
  using Matrix9d = Eigen::Matrix<double, 9, 9>;
  using Matrix39d = Eigen::Matrix<double, 3, 9>;

  template <typename T>
  static Vector9<T> predict(const Vector9<T>& x, double dt) {
    const Vector3<T> y = x.template head<3>();
    const Vector3<T> v = x.template segment<3>(3), a = x.template tail<3>();
    const T rho = P::inverse_depth(y);
    const Vector3<T> g = P::direction(y) + rho * (v * T(dt) + a * T(0.5 * dt * dt));
    Vector9<T> next;
    next << P::of(g, T(rho / g.norm()), y), v + a * T(dt), a;
    return next;
  }

  static Matrix9d predict_jacobian(const Vector9d& x, double dt) {
    const Eigen::Vector3d y = x.head<3>();
    const double rho = P::inverse_depth(y);
    const Eigen::RowVector3d J_rho_y = P::inverse_depth_jacobian(y);
    const Eigen::Vector3d s = x.segment<3>(3) * dt + x.tail<3>() * (0.5 * dt * dt);
    const Eigen::Vector3d g = P::direction(y) + rho * s;
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    Matrix39d J_g_x;
    J_g_x << P::direction_jacobian(y) + s * J_rho_y, rho * dt * I, 0.5 * rho * dt * dt * I;
    const double n = g.norm();
    Eigen::Matrix<double, 1, 9> J_next_x = -rho / (n * n * n) * g.transpose() * J_g_x;
    J_next_x.head<3>() += J_rho_y / n;
    Matrix9d F = Matrix9d::Identity();
    F.topRows<3>() = moved_jacobian<P>(g, rho / n, J_g_x, J_next_x);
    F.block<3, 3>(3, 6) = dt * I;
    return F;
  }

  // The integrals of white jerk over dt: (sigma_j dt)^2 [dt^4/20 dt^3/8 dt^2/6; . dt^2/3 dt/2; . .
  // 1].
  static Eigen::Matrix3d jerk_pattern(double dt) {
    const double d2 = dt * dt;
    Eigen::Matrix3d pattern;
    pattern << d2 * d2 / 20.0, d2 * dt / 8.0, d2 / 6.0,  //
        d2 * dt / 8.0, d2 / 3.0, dt / 2.0,               //
        d2 / 6.0, dt / 2.0, 1.0;
    return pattern * d2;
  }

  static Matrix9d metric_noise_root(const LandmarkPrior& prior, double dt) {
    const Eigen::Matrix3d L = jerk_pattern(dt).llt().matrixL();
    Matrix9d root = Matrix9d::Zero();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) {
        root.block<3, 3>(3 * i, 3 * j).diagonal().setConstant(prior.jerk * L(i, j));
      }
    }
    return root;
  }
  static Matrix9d noise_jacobian(const Vector9d& x) {
    Matrix9d J = Matrix9d::Identity();
    J.topLeftCorner<3, 3>() = noise_jacobian_static<P>(x.head<3>());
    return J;
  }

  static Eigen::Vector3d velocity(const Vector9d& x) { return x.segment<3>(3); }
  static Matrix39d velocity_jacobian(const Vector9d&) {
    Matrix39d J = Matrix39d::Zero();
    J.middleCols<3>(3).setIdentity();
    return J;
  }
  static Vector6d motion_of(const Eigen::Vector3d& /*y*/, const Eigen::Vector3d& v) {
    return (Vector6d() << v, Eigen::Vector3d::Zero()).finished();
  }
  static double density_scale(const Vector9d&) { return 1.0; }
  static Vector6d prior_sigmas(const LandmarkPrior& prior) {
    return (Vector6d() << Eigen::Vector3d::Constant(prior.velocity_sigma()),
            Eigen::Vector3d::Constant(prior.acceleration))
        .finished();
  }
};

}  // namespace slammot
