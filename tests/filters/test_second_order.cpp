// What the EKF states of the product of a landmark's depth and the camera's translation. What it
// does to accuracy and consistency: eval/studies/devices.yaml.
#include "filters/second_order.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"
#include "models/landmarks/landmark_models.h"

namespace slammot {
namespace {

using Product = std::function<Eigen::Vector2d(const Eigen::VectorXd& errors)>;

// The covariance of two products of errors, by a rule that is exact for Gaussian moments up to the
// fifth (McNamee & Stenger 1967).
Eigen::Matrix2d covariance_of(const Product& f, const Product& g, const Eigen::MatrixXd& P) {
  const Eigen::MatrixXd L = P.llt().matrixL();
  const Eigen::Index n = P.rows();
  const auto size = static_cast<double>(n);
  Eigen::Vector2d of_f = Eigen::Vector2d::Zero(), of_g = of_f;
  Eigen::Matrix2d both = Eigen::Matrix2d::Zero();
  const auto add = [&](const Eigen::VectorXd& unit, double weight) {
    const Eigen::Vector2d a = f(L * unit), b = g(L * unit);
    of_f += weight * a;
    of_g += weight * b;
    both += weight * a * b.transpose();
  };
  add(Eigen::VectorXd::Zero(n), (size * size - 7.0 * size + 18.0) / 18.0);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (const double a : {std::sqrt(3.0), -std::sqrt(3.0)}) {
      const Eigen::VectorXd first = a * Eigen::VectorXd::Unit(n, i);
      add(first, (4.0 - size) / 18.0);
      for (Eigen::Index j = 0; j < i; ++j) {
        for (const double b : {a, -a}) add(first + b * Eigen::VectorXd::Unit(n, j), 1.0 / 36.0);
      }
    }
  }
  return both - of_f * of_g.transpose();
}

// Whatever depths and translations have in common: of camera, anchor and y of one landmark, and of
// camera, two anchors and two inverse depths.
TEST(SecondOrder, IsTheCovarianceOfTheProductsOfDepthAndTranslation) {
  const PointFunctions& point = find_point("inverse_depth");
  const Camera camera{640, 480, 385.0, 385.0, 319.5, 239.5, PinholeLens{}};
  const Eigen::Vector3d y(0.2, -0.1, 0.3);  // (theta, phi, rho)
  const auto at = [&](const Eigen::Vector3d& of_y) {
    return observe(camera, point, {0.1, -0.05, 0.02}, Eigen::Quaterniond::Identity(),
                   Eigen::Vector3d::Zero(), of_y)
        .value();
  };
  const ObservedPixel h = at(y), other = at({-0.3, 0.2, 0.1});
  const auto product = [](const ObservedPixel& of, Eigen::Index rho, Eigen::Index anchor) {
    return [=](const Eigen::VectorXd& e) -> Eigen::Vector2d {
      return of.J_world * (e(rho) * (e.segment<3>(anchor) - e.head<3>()));
    };
  };
  const auto any_covariance = [](Eigen::Index n) -> Eigen::MatrixXd {
    const Eigen::MatrixXd A = Eigen::MatrixXd::Random(n, n);
    return 1e-3 * (A * A.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n));
  };
  std::srand(5);
  const Eigen::MatrixXd P = any_covariance(9), Q = any_covariance(11);
  const Eigen::Matrix2d one = second_order_noise(point, y, PositionsCovariance(P), h);
  EXPECT_LT((one - covariance_of(product(h, 8, 3), product(h, 8, 3), P)).norm(), 1e-9 * one.norm());

  const auto block = [&](int i, int j) { return Q.block<3, 3>(i, j); };
  ProductMoments moments;
  moments.e_e = Q(9, 10);
  moments.d_d = block(3, 6) - block(3, 0) - block(0, 6) + block(0, 0);
  moments.d_e = Q.block<3, 1>(3, 10) - Q.block<3, 1>(0, 10);
  moments.e_d = Q.block<3, 1>(6, 9) - Q.block<3, 1>(0, 9);
  const Eigen::Matrix2d two = second_order_noise(h.J_world, other.J_world, moments);
  EXPECT_LT((two - covariance_of(product(h, 9, 3), product(other, 10, 6), Q)).norm(),
            1e-9 * two.norm());
}

// Most landmarks stand farther than is stated, and the first velocity is not known. A translation
// that their depths do not tell must not reject the four that know theirs. Without the blocks
// beside the diagonal the error is a tenth of the path.
TEST(SecondOrder, KnownLandmarksAreBelievedWhereTheMeanDepthIsNotKnown) {
  double share = 1.0;  // of the path, geometric mean
  for (const std::uint64_t seed : {1u, 2u}) {
    const Sequence sequence = simulate(
        "circle", {{"frames", "4"}, {"moving", "0"}, {"noise", "0.1"}, {"stated_noise", "0.1"}},
        seed);
    Configuration configuration;
    configuration.model.labels.births = Births::kStaticFirst;  // as they are
    slammot::Setup setup = make_setup(sequence, configuration);
    setup.prior = {};
    setup.prior.inverse_depth = 0.5;
    setup.prior.inverse_depth_sigma = 0.25;
    setup.prior.mean_sigma = 0.5;
    setup.initial.velocity_sigma = 2.0;
    setup.initial.angular_velocity_sigma = 1.0;
    setup.initial.state.velocity.setZero();
    setup.initial.state.angular_velocity.setZero();
    const auto ekf = make_ekf(setup, configuration.model, configuration.ekf);
    NoStages stages;
    for (const Frame& frame : sequence.frames) ekf->process(frame, stages);
    const Eigen::Vector3d truth = sequence.truth.back()->position;
    const double path = (truth - sequence.truth.front()->position).norm();
    share *= std::sqrt((ekf->camera().state.position - truth).norm() / path);
  }
  EXPECT_LT(share, 0.05);
}

}  // namespace
}  // namespace slammot
