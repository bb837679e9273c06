// What tests of models share: states at random and nearly degenerate ones, points in every
// parametrisation, tests over types, and the comparison with Ceres' automatic differentiation.
#pragma once

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <random>

#include "models/camera_state.h"
#include "models/points/all_points.h"

namespace slammot::test {

inline constexpr int kStates = 500;
inline constexpr double kRelative = 1e-7;

template <int N>
using Jet = ceres::Jet<double, N>;

// |A - B| relative to the largest entry of B.
template <typename A, typename B>
void expect_same(const A& analytic, const B& automatic, const std::string& what) {
  const double scale = std::max(automatic.cwiseAbs().maxCoeff(), 1e-12);
  const double error = (analytic - automatic).cwiseAbs().maxCoeff() / scale;
  ASSERT_TRUE(std::isfinite(scale)) << what;
  ASSERT_LT(error, kRelative) << what << "\nanalytic\n" << analytic << "\nautomatic\n" << automatic;
}

template <int Rows, int N, typename V>
Eigen::Matrix<double, Rows, N> derivatives(const V& values) {
  Eigen::Matrix<double, Rows, N> J;
  for (int i = 0; i < Rows; ++i) J.row(i) = values(i).v.transpose();
  return J;
}

class Random {
 public:
  double normal() { return normal_(engine_); }
  double uniform(double a, double b) { return a + (b - a) * uniform_(engine_); }
  Eigen::Vector3d vector(double sigma) {
    return Eigen::Vector3d(normal(), normal(), normal()) * sigma;
  }
  // Every fourth one is zero or tiny.
  Eigen::Vector3d rotation() {
    const Eigen::Vector3d v = vector(1.0);
    const int kind = count_++ % 8;
    if (kind == 0) return Eigen::Vector3d::Zero();
    return kind == 1 ? Eigen::Vector3d(v * 1e-9) : v;
  }
  // (theta, phi, rho) with rho near 0 and phi near +-pi/2 among them.
  Eigen::Vector3d y() {
    Eigen::Vector3d y(uniform(-3.0, 3.0), uniform(-1.5, 1.5), uniform(-0.2, 1.0));
    const int kind = count_++ % 10;
    if (kind == 0) y.z() = 1e-12 * normal();
    if (kind == 1) y.z() = 0.0;
    if (kind == 2) y.y() = (normal() > 0 ? 1.0 : -1.0) * (M_PI / 2 - 1e-3);
    return y;
  }

 private:
  std::mt19937_64 engine_{20100719};
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_;
  int count_ = 0;
};

inline CameraState random_camera(Random& random) {
  CameraState x;
  x.position = random.vector(3.0);
  x.orientation = exp_so3(random.rotation());
  x.velocity = random.vector(2.0);
  x.angular_velocity = random.rotation();
  return x;
}

// All types of a tuple, for a typed test suite.
template <typename>
struct TypesOf;
template <typename... M>
struct TypesOf<std::tuple<M...>> {
  using Type = testing::Types<M...>;
};

// As Random::y(), with rho near 0 and below only where there are such points.
template <PointParametrisation P>
Eigen::Vector3d random_point(Random& random) {
  const Eigen::Vector3d angles_and_rho = random.y();
  const Eigen::Vector3d G = InverseDepth::direction(angles_and_rho);
  double rho = angles_and_rho.z();
  if (!P::exists(G, 0.0)) rho = std::max(std::abs(rho), 0.01);
  return P::of(G, rho, angles_and_rho);
}

}  // namespace slammot::test
