// A landmark model, as docs/extending.md adds one: what stands between the `example` and `end`
// lines is quoted there, and that it compiles is half the test.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "estimation/landmark_estimate.h"
#include "models/landmarks/landmark.h"
#include "models/points/inverse_depth.h"
#include "models/points/point_functions.h"

namespace slammot {
namespace {

// [example: landmark model]
// A velocity that decays: x = (y, v), v' = e^(-dt/tau) v.
template <PointParametrisation P>
struct DecayingVelocity {
  using Point = P;
  static constexpr std::string_view kName = "decaying_velocity";
  static constexpr std::string_view kDescription = "a velocity that decays";
  static constexpr int kMotion = 3;    // numbers of w, here v
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
// [end]

using Decaying = DecayingVelocity<InverseDepth>;
const PointFunctions& point = find_point("inverse_depth");

Vector6d random_landmark(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Vector6d x;
  x << 3.0 * unit(engine), 1.4 * unit(engine), 0.4 + 0.5 * unit(engine), 2.0 * unit(engine),
      2.0 * unit(engine), 2.0 * unit(engine);
  return x;
}

TEST(ExtendingLandmark, JacobianIsThatOfThePrediction) {
  std::mt19937_64 engine(1);
  for (int k = 0; k < 500; ++k) {
    const Vector6d x = random_landmark(engine);
    const double dt = 0.02 + 0.001 * (k % 100);
    const Matrix6d F = Decaying::predict_jacobian(x, dt);
    for (int i = 0; i < 6; ++i) {
      constexpr double kStep = 1e-5;
      const Vector6d d = kStep * Vector6d::Unit(i);
      const Vector6d numeric =
          (Decaying::predict(Vector6d(x + d), dt) - Decaying::predict(Vector6d(x - d), dt)) /
          (2.0 * kStep);
      ASSERT_LT((numeric - F.col(i)).norm(), 1e-7 * F.norm()) << x.transpose() << ", column " << i;
    }
  }
}

TEST(ExtendingLandmark, MovesAndNoiseStandsInMetres) {
  std::mt19937_64 engine(2);
  for (int k = 0; k < 100; ++k) {
    const Vector6d x = random_landmark(engine);
    if (std::abs(x(2)) < 1e-2) continue;
    // Two half steps are one step: the prediction is that of a differential equation.
    const Vector6d halves = Decaying::predict(Decaying::predict(x, 0.05), 0.05);
    EXPECT_LT((halves - Decaying::predict(x, 0.1)).norm(), 1e-12);
    Matrix6d J_metric = Matrix6d::Zero();
    J_metric.topLeftCorner<3, 3>() = position_jacobian(point, x.head<3>());
    J_metric.bottomRows<3>() = Decaying::velocity_jacobian(x);
    const Matrix6d I = Decaying::noise_jacobian(x) * J_metric;
    EXPECT_LT((I - Matrix6d::Identity()).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_TRUE(landmark_noise_root<Decaying>(x, LandmarkPrior{}, 0.1).allFinite());
  }
}

}  // namespace
}  // namespace slammot
