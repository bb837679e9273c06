// What the EKF states of the product of a landmark's depth and the camera's translation.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"
#include "filters/second_order.h"
#include "models/landmarks/landmark_models.h"
#include "tests/filters/pose_nees.h"

namespace slammot {
namespace {

const PointFunctions& kPoint = find_point("inverse_depth");
const Camera kCamera{640, 480, 385.0, 385.0, 319.5, 239.5, PinholeLens{}};

// Whatever depth and translation have in common.
TEST(SecondOrder, IsTheCovarianceOfTheProductOfDepthAndTranslation) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  const PositionsCovariance A =
      PositionsCovariance::NullaryExpr([&](Eigen::Index, Eigen::Index) { return normal(engine); });
  const PositionsCovariance P = 1e-3 * A * A.transpose(), L = P.llt().matrixL();
  const Eigen::Vector3d y(0.2, -0.1, 0.3);
  const auto h = observe(kCamera, kPoint, {0.1, -0.05, 0.02}, Eigen::Quaterniond::Identity(),
                         Eigen::Vector3d::Zero(), y);
  ASSERT_TRUE(h);
  constexpr int kDraws = 200000;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    Eigen::Vector<double, 9> e;
    for (double& value : e) value = normal(engine);
    e = (L * e).eval();
    const Eigen::Vector3d d = e.segment<3>(3) - e.head<3>();
    const Eigen::Vector2d left_out = h->J_world * (e(8) * d);  // y is (theta, phi, rho)
    sum += left_out;
    squares += left_out * left_out.transpose();
  }
  const Eigen::Matrix2d drawn = squares / kDraws - sum * sum.transpose() / kDraws / kDraws;
  const Eigen::Matrix2d N = second_order_noise(kPoint, y, P, *h);
  EXPECT_LT((N - drawn).norm(), 0.03 * N.norm());
}

// Of camera, two anchors and two inverse depths, whatever they have in common.
TEST(SecondOrder, OfTwoLandmarksIsTheCovarianceOfTheirProducts) {
  using Joint = Eigen::Matrix<double, 11, 11>;
  std::mt19937_64 engine(6);
  std::normal_distribution<double> normal;
  const Joint A = Joint::NullaryExpr([&](Eigen::Index, Eigen::Index) { return normal(engine); });
  const Joint P = 1e-3 * A * A.transpose(), L = P.llt().matrixL();
  const Eigen::Vector3d y_i(0.2, -0.1, 0.3), y_j(-0.3, 0.2, 0.1);
  const auto at = [&](const Eigen::Vector3d& y) {
    return *observe(kCamera, kPoint, {0.1, -0.05, 0.02}, Eigen::Quaterniond::Identity(),
                    Eigen::Vector3d::Zero(), y);
  };
  const ObservedPixel h_i = at(y_i), h_j = at(y_j);
  constexpr int kDraws = 2000000;
  Eigen::Vector2d sum_i = Eigen::Vector2d::Zero(), sum_j = sum_i;
  Eigen::Matrix2d products = Eigen::Matrix2d::Zero();
  for (int k = 0; k < kDraws; ++k) {
    Eigen::Vector<double, 11> e;
    for (double& value : e) value = normal(engine);
    e = (L * e).eval();
    const Eigen::Vector2d of_i = h_i.J_world * (e(9) * (e.segment<3>(3) - e.head<3>()));
    const Eigen::Vector2d of_j = h_j.J_world * (e(10) * (e.segment<3>(6) - e.head<3>()));
    sum_i += of_i;
    sum_j += of_j;
    products += of_i * of_j.transpose();
  }
  const Eigen::Matrix2d drawn = products / kDraws - sum_i * sum_j.transpose() / kDraws / kDraws;
  const auto block = [&](int i, int j) { return P.block<3, 3>(i, j); };
  ProductMoments moments;
  moments.e_e = P(9, 10);
  moments.d_d = block(3, 6) - block(3, 0) - block(0, 6) + block(0, 0);
  moments.d_e = P.block<3, 1>(3, 10) - P.block<3, 1>(0, 10);
  moments.e_d = P.block<3, 1>(6, 9) - P.block<3, 1>(0, 9);
  const Eigen::Matrix2d N = second_order_noise(h_i.J_world, h_j.J_world, moments);
  EXPECT_LT((N - drawn).norm(), 0.05 * N.norm());
}

// The mean NEES of the pose of a camera whose motion is not known, among landmarks that stand
// nearer than is stated.
double nees_at_the_start(std::uint64_t seed, bool second_order) {
  const Sequence sequence = simulate(
      "circle", {{"frames", "30"}, {"moving", "0"}, {"noise", "0.3"}, {"stated_noise", "0.3"}},
      seed);
  Configuration configuration;
  configuration.model.classifier.name = "all_static";
  configuration.ekf.second_order = second_order;
  slammot::Setup setup = make_setup(sequence, configuration);
  setup.known.clear();
  setup.prior.inverse_depth *= 0.5;
  const CameraState truth = setup.initial.state;
  setup.initial.velocity_sigma = truth.velocity.norm();
  setup.initial.angular_velocity_sigma = 1.0;
  setup.initial.state.velocity.setZero();
  setup.initial.state.angular_velocity.setZero();
  const auto ekf = make_ekf(setup, configuration.model, configuration.ekf);
  return mean_pose_nees(*ekf, sequence);
}

TEST(SecondOrder, ClaimsLessWhereMotionAndDepthsAreUnknown) {
  double ratio = 1.0;
  constexpr int kSeeds = 2;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const double with = nees_at_the_start(seed, true), without = nees_at_the_start(seed, false);
    std::printf("seed %d: NEES %.0f, without %.0f\n", static_cast<int>(seed), with, without);
    ratio *= std::pow(with / without, 1.0 / kSeeds);
  }
  EXPECT_LT(ratio, 0.85);
}

// Most landmarks stand farther than is stated, and the first velocity is not known. A translation
// that their depths do not tell must not reject the four that know theirs. Without the blocks
// beside the diagonal the error is a tenth of the path.
TEST(SecondOrder, KnownLandmarksAreBelievedWhereTheMeanDepthIsNotKnown) {
  constexpr int kSeeds = 2;
  double share = 1.0;  // of the path, geometric mean
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Sequence sequence = simulate(
        "circle", {{"frames", "4"}, {"moving", "0"}, {"noise", "0.1"}, {"stated_noise", "0.1"}},
        seed);
    Configuration configuration;
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
    double error = 0.0, path = 0.0;
    for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
      ekf->process(sequence.frames[i], stages);
      const Eigen::Vector3d truth = sequence.truth[i]->position;
      path = (truth - sequence.truth[0]->position).norm();
      error = (ekf->camera().state.position - truth).norm();
    }
    std::printf("seed %d: %.4f of %.3f m\n", static_cast<int>(seed), error, path);
    share *= std::pow(error / path, 1.0 / kSeeds);
  }
  EXPECT_LT(share, 0.05);
}

}  // namespace
}  // namespace slammot
