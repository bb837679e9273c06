// The Jacobians of every cost function.
#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <random>

#include "models/camera_motion.h"
#include "models/landmarks/landmark_models.h"
#include "smoothers/factors/camera_manifold.h"
#include "smoothers/factors/factors.h"
#include "smoothers/factors/landmark_chain.h"
#include "smoothers/graph/graph.h"
#include "tests/smoothers/fixture.h"

namespace slammot {
namespace {

// Each cost function's Jacobian, brought to the tangent space, against central differences there.
void expect_gradients(const ceres::CostFunction& cost, std::vector<SmallVector> values,
                      const MotionManifold& manifold) {
  using RowMajorMatrix = Eigen::Matrix<double, -1, -1, Eigen::RowMajor>;
  const auto manifold_of = [&](const SmallVector& v) {
    return v.size() == kMotionSize ? &manifold : nullptr;
  };
  const auto residuals = [&](const std::vector<SmallVector>& x, double** jacobians) {
    std::vector<const double*> blocks;
    for (const SmallVector& v : x) blocks.push_back(v.data());
    Eigen::VectorXd r(cost.num_residuals());
    EXPECT_TRUE(cost.Evaluate(blocks.data(), r.data(), jacobians));
    return r;
  };
  std::vector<RowMajorMatrix> ambient;
  for (const SmallVector& v : values) ambient.emplace_back(cost.num_residuals(), v.size());
  std::vector<double*> jacobians;
  for (RowMajorMatrix& J : ambient) jacobians.push_back(J.data());
  residuals(values, jacobians.data());
  for (std::size_t k = 0; k < values.size(); ++k) {
    const MotionManifold* m = manifold_of(values[k]);
    RowMajorMatrix P = RowMajorMatrix::Identity(values[k].size(), values[k].size());
    if (m) {
      P.resize(kMotionSize, kMotionDim);
      m->PlusJacobian(values[k].data(), P.data());
    }
    const Eigen::MatrixXd J = ambient[k] * P;
    for (Eigen::Index i = 0; i < J.cols(); ++i) {
      constexpr double kStep = 1e-5;
      SmallVector d = SmallVector::Zero(J.cols());
      d(i) = kStep;
      std::vector<SmallVector> ahead = values, behind = values;
      ahead[k] = plus(m, values[k], d);
      behind[k] = plus(m, values[k], -d);
      const Eigen::VectorXd numeric =
          (residuals(ahead, nullptr) - residuals(behind, nullptr)) / (2.0 * kStep);
      ASSERT_LT((numeric - J.col(i)).norm(), 1e-6 * std::max(J.norm(), 1.0))
          << "block " << k << " column " << i;
    }
  }
}

TEST(Factors, JacobiansOnTheManifold) {
  MotionManifold manifold;
  std::mt19937_64 engine(11);
  std::normal_distribution<double> normal;
  const auto vector = [&](double s) {
    return Eigen::Vector3d(s * normal(engine), s * normal(engine), s * normal(engine));
  };
  for (int k = 0; k < 200; ++k) {
    CameraState a = test::camera_at(normal(engine), 0.3 * normal(engine));
    CameraState b = predict(a, 0.1);
    b = boxplus(b, Vector12d(Vector12d::Random() * 0.05));
    SmallVector pa(3), ma(kMotionSize), pb(3), mb(kMotionSize);
    camera_to_blocks(a, pa.data(), ma.data());
    camera_to_blocks(b, pb.data(), mb.data());
    InitialCamera initial;
    initial.state = b;
    initial.position_sigma = initial.rotation_sigma = 0.1;
    expect_gradients(*initial_camera_cost(initial), {pa, ma}, manifold);
    const Matrix12d Q = camera_noise({1.0, 1.0}, a, 0.1);
    expect_gradients(*camera_motion_cost(Q, 0.1), {pa, ma, pb, mb}, manifold);
    const SmallVector anchor = a.position + vector(0.3);
    const Eigen::Vector3d ray = a.orientation * Eigen::Vector3d(0.2 * normal(engine), 0.1, 1.0);
    SmallVector y(3);
    y << angles(ray, 0.0), 0.2;
    expect_gradients(*pixel_cost(test::pinhole(), {300, 200}, 1.0), {pa, ma, anchor, y}, manifold);
    expect_gradients(*first_pixel_cost(test::pinhole(), {300, 200}, 1.0), {ma, y}, manifold);
    const SmallVector mean = SmallVector::Constant(1, 0.3);
    expect_gradients(*shared_inverse_depth_cost({}), {y, mean}, manifold);
    expect_gradients(*known_landmark_cost({1, vector(2.0), 0.1}), {anchor, y}, manifold);
    for (const LandmarkFunctions& landmark : landmark_table()) {
      auto chain = std::make_shared<Chain>(Chain{&landmark, {}});
      SmallVector w(landmark.motion);
      for (double& v : w) v = 0.3 * normal(engine);
      std::vector<SmallVector> blocks{pa, ma, anchor, y, w};
      const LandmarkVector x = landmark_state(y, w);
      for (int i = 0; i < 3; ++i) {
        chain->steps.push_back({0.1, landmark.noise_root(x, LandmarkPrior{}, 0.1)});
        SmallVector noise(landmark.dim());
        for (double& v : noise) v = normal(engine);
        blocks.push_back(noise);
      }
      expect_gradients(ChainPixelCost(test::pinhole(), {300, 200}, 1.0, chain, 3), blocks,
                       manifold);
    }
  }
}

}  // namespace
}  // namespace slammot
