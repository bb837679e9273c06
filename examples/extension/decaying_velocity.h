// A landmark model for any parametrisation of its position.
#pragma once

#include <slammot/models/landmarks/landmark.h>
#include <slammot/models/points/inverse_depth.h>
#include <slammot/models/points/point_functions.h>

namespace slammot {

// A velocity that decays: x = (y, v), v' = e^(-dt/tau) v.
template <PointParametrisation P>
struct DecayingVelocity {
  using Point = P;
  static constexpr std::string_view kName = "decaying_velocity";
  static constexpr std::string_view kDescription = "a velocity that decays";
  static constexpr int kMotion = 3;  // numbers of w, here v
  static constexpr bool kMotionInMetres = true;
  static constexpr double kTau = 2.0;  // [s]

  static double decay(double dt) { return std::exp(-dt / kTau); }
  static double travel(double dt) { return kTau * (1.0 - decay(dt)); }  // of a unit velocity

  template <typename T>
  static Vector6<T> predict(const Vector6<T>& x, double dt) {
    const Vector3<T> y = x.template head<3>(), v = x.template tail<3>();
    const T rho = P::inverse_depth(y);
    const Vector3<T> g = P::direction(y) + rho * v * T(travel(dt));
    Vector6<T> next;
    next << P::of(g, T(rho / g.norm()), y), v * T(decay(dt));
    return next;
  }

  static Matrix6d predict_jacobian(const Vector6d& x, double dt) {
    const Eigen::Vector3d y = x.head<3>(), s = x.tail<3>() * travel(dt);
    const double rho = P::inverse_depth(y);
    const Eigen::RowVector3d J_rho_y = P::inverse_depth_jacobian(y);
    const Eigen::Vector3d g = P::direction(y) + rho * s;
    Matrix36d J_g_x;
    J_g_x << P::direction_jacobian(y) + s * J_rho_y, rho * travel(dt) * Eigen::Matrix3d::Identity();
    const double n = g.norm();
    Eigen::Matrix<double, 1, 6> J_next_x = -rho / (n * n * n) * g.transpose() * J_g_x;
    J_next_x.head<3>() += J_rho_y / n;  // of rho' = rho / |g|
    Matrix6d F = Matrix6d::Zero();
    F.topRows<3>() = moved_jacobian<P>(g, rho / n, J_g_x, J_next_x);
    F.bottomRightCorner<3, 3>().diagonal().setConstant(decay(dt));
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
static_assert(LandmarkModel<DecayingVelocity<InverseDepth>>);

}  // namespace slammot
