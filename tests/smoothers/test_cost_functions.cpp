// The Jacobians of every cost function, and with them those of the residuals they share with the
// window's own solver. That of a marginal prior: test_marginal_prior.cpp.
#include <gtest/gtest.h>

#include <random>

#include "models/camera_motion.h"
#include "smoothers/ceres/cost_functions.h"
#include "smoothers/ceres/manifolds.h"
#include "smoothers/graph/chain_step.h"
#include "smoothers/scale/noise_scale.h"
#include "tests/smoothers/fixture/cameras.h"

namespace slammot {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, -1, -1, Eigen::RowMajor>;

Eigen::VectorXd residuals(const ceres::CostFunction& cost, const std::vector<SmallVector>& x,
                          double** jacobians) {
  std::vector<const double*> blocks;
  for (const SmallVector& v : x) blocks.push_back(v.data());
  Eigen::VectorXd r(cost.num_residuals());
  EXPECT_TRUE(cost.Evaluate(blocks.data(), r.data(), jacobians));
  return r;
}

// Each Jacobian, brought to the tangent space, against central differences there. Only
// orientations have four numbers, but w of no model and no noise has.
void expect_gradients(const ceres::CostFunction& cost, const std::vector<SmallVector>& values) {
  const OrientationManifold manifold;
  std::vector<RowMajorMatrix> ambient;
  for (const SmallVector& v : values) ambient.emplace_back(cost.num_residuals(), v.size());
  std::vector<double*> jacobians;
  for (RowMajorMatrix& J : ambient) jacobians.push_back(J.data());
  const Eigen::VectorXd r = residuals(cost, values, jacobians.data());
  EXPECT_EQ(r, residuals(cost, values, nullptr));
  for (std::size_t k = 0; k < values.size(); ++k) {
    const bool is_orientation = values[k].size() == 4;
    RowMajorMatrix P = RowMajorMatrix::Identity(values[k].size(), values[k].size());
    if (is_orientation) {
      P.resize(4, 3);
      manifold.PlusJacobian(values[k].data(), P.data());
    }
    const Eigen::MatrixXd J = ambient[k] * P;
    for (Eigen::Index i = 0; i < J.cols(); ++i) {
      constexpr double kStep = 1e-5;
      SmallVector d = SmallVector::Zero(J.cols());
      d(i) = kStep;
      std::vector<SmallVector> ahead = values, behind = values;
      ahead[k] = plus(is_orientation, values[k], d);
      behind[k] = plus(is_orientation, values[k], -d);
      const Eigen::VectorXd numeric =
          (residuals(cost, ahead, nullptr) - residuals(cost, behind, nullptr)) / (2.0 * kStep);
      ASSERT_LT((numeric - J.col(i)).norm(), 1e-6 * std::max(J.norm(), 1.0))
          << "block " << k << " column " << i;
    }
  }
}

// The three blocks of a camera.
std::vector<SmallVector> blocks_of(const CameraState& x) {
  Vector6d rates;
  rates << x.velocity, x.angular_velocity;
  return {x.position, x.orientation.coeffs(), rates};
}

struct CostFunctions : testing::Test {
  std::mt19937_64 engine{11};
  std::normal_distribution<double> normal;
  GraphModels models{test::pinhole(), 2.0, {}, &landmark_table().front()};
  CameraState a, b;
  SmallVector anchor, y;

  Eigen::VectorXd normals(Eigen::Index size, double sigma) {
    return Eigen::VectorXd::NullaryExpr(size, [&] { return sigma * normal(engine); });
  }
  void draw() {
    a = test::camera_at(normal(engine), 0.3 * normal(engine));
    b = boxplus(predict(a, 0.1), Vector12d(normals(12, 0.05)));
    anchor = a.position + Eigen::Vector3d(normals(3, 0.3));
    const Eigen::Vector3d ray = a.orientation * Eigen::Vector3d(0.2 * normal(engine), 0.1, 1.0);
    y = models.point().of(ray, 0.2, Eigen::Vector3d::Zero());
  }
};

TEST_F(CostFunctions, OfCameras) {
  for (int k = 0; k < 40; ++k) {
    draw();
    InitialCamera initial;
    initial.state = b;
    initial.position_sigma = initial.rotation_sigma = 0.1;
    std::vector<SmallVector> both = blocks_of(a);
    expect_gradients(*initial_camera_cost(initial), both);
    for (const SmallVector& block : blocks_of(b)) both.push_back(block);
    const Matrix12d weight = square_root_information(camera_noise({1.0, 1.0}, a, 0.1));
    expect_gradients(*camera_motion_cost(weight, 0.1), both);
    for (const double ratio : {0.5, 0.95, 1.0, 1.05, 2.0}) {  // in units of the speed
      const double speed = ratio * unit_of_speed(b.velocity, unknown_speed(weight));
      expect_gradients(*camera_motion_cost(weight, 0.1, speed), both);
    }
  }
}

// In units of the speed a step costs the same in a world of any size, but for e.
TEST_F(CostFunctions, NoiseInUnitsOfTheSpeedHasNoScale) {
  for (int k = 0; k < 40; ++k) {
    draw();
    a.velocity *= 10.0;
    b = boxplus(predict(a, 0.1), Vector12d(normals(12, 0.05)));
    const auto both = [&](double scale) {
      std::vector<SmallVector> blocks;
      for (CameraState x : {a, b}) {
        x.position *= scale;
        x.velocity *= scale;
        for (const SmallVector& block : blocks_of(x)) blocks.push_back(block);
      }
      return blocks;
    };
    const Matrix12d weight = square_root_information(camera_noise({1.0, 1.0}, a, 0.1));
    const auto in_units = camera_motion_cost(weight, 0.1, b.velocity.norm());
    const Eigen::VectorXd r = residuals(*in_units, both(1.0), nullptr);
    EXPECT_LT((residuals(*in_units, both(1.08), nullptr) - r).norm(), 1e-3 * r.norm());
    const auto in_metres = camera_motion_cost(weight, 0.1);
    EXPECT_LT((residuals(*in_metres, both(1.0), nullptr) - r).norm(), 1e-3 * r.norm());
    const Eigen::Vector3d linear = r.segment<3>(kVelocity);
    EXPECT_GT(residuals(*in_metres, both(1.08), nullptr).segment<3>(kVelocity).norm(),
              1.07 * linear.norm());
  }
}

// A fixed spread costs a large scene less, where all inverse depths are near their mean.
TEST(DepthResidual, OfARelativeSpreadIsTheSameInAWorldOfAnySize) {
  const DepthSpread fixed{0.1, 0.0}, relative{0.1, 0.3};
  EXPECT_EQ(depth_residual(relative, 0.5, 0.3).r, depth_residual(fixed, 0.5, 0.3).r);
  EXPECT_EQ(depth_residual(relative, 0.3, 0.3).J_mean, depth_residual(fixed, 0.3, 0.3).J_mean);
  for (const double size : {0.1, 0.5, 3.0, 50.0}) {
    EXPECT_NEAR(depth_residual(relative, 0.5 / size, 0.3 / size).r, 2.0, 1e-12);
    EXPECT_NEAR(depth_residual(fixed, 0.5 / size, 0.3 / size).r, 2.0 / size, 1e-12);
  }
}

TEST_F(CostFunctions, OfStaticLandmarks) {
  for (int k = 0; k < 40; ++k) {
    const auto points = point_table();
    models.landmark = &landmark_table(points[static_cast<std::size_t>(k) % points.size()]).front();
    draw();
    const std::vector<SmallVector> pose = blocks_of(a);
    expect_gradients(*pixel_cost(models, {{300, 200}, false}), {pose[0], pose[1], anchor, y});
    expect_gradients(*pixel_cost(models, {{300, 200}, true}), {pose[1], y});
    BirthPrior birth;
    birth.inverse_depth = 0.3;
    birth.spread.sigma = 0.1;
    birth.kind = BirthPrior::Kind::kDepth;
    expect_gradients(*birth_cost(models.point(), birth), {y});
    birth.kind = BirthPrior::Kind::kSharedDepth;
    expect_gradients(*birth_cost(models.point(), birth), {y, SmallVector::Constant(1, 0.25)});
    birth.spread.about = 0.4;
    for (const double mean : {0.25, 0.4, 0.9, 0.003, -0.1}) {  // and where the spread is the least
      expect_gradients(*birth_cost(models.point(), birth), {y, SmallVector::Constant(1, mean)});
    }
    birth.kind = BirthPrior::Kind::kKnown;
    birth.known = {1, normals(3, 2.0), 0.1};
    expect_gradients(*birth_cost(models.point(), birth), {anchor, y});
    expect_gradients(*gaussian_cost(normals(5, 1.0), Eigen::VectorXd::LinSpaced(5, 0.1, 2.0)),
                     {normals(5, 1.0)});
  }
}

// Those whose motion is in metres: in units of the distance.
TEST_F(CostFunctions, OfFreeLandmarks) {
  for (const LandmarkFunctions& landmark : landmark_table()) {
    models.noise_tells_scale = !landmark.motion_in_metres;
    SCOPED_TRACE(std::string(landmark.name) + " " + std::string(landmark.point.name));
    models.landmark = &landmark;
    for (int k = 0; k < 10; ++k) {
      draw();
      const SmallVector w = normals(landmark.motion, 0.3);
      const LandmarkVector x = landmark_state(Eigen::Vector3d(y), w);
      const std::vector<SmallVector> pose = blocks_of(a);
      std::vector<SmallVector> blocks{pose[0], pose[1], anchor, y, w};
      std::vector<ChainStep> chain(4);  // longer than the pixel is deep
      for (ChainStep& step : chain) {
        step.dt = 0.1;
        step.G = landmark.noise_root(x, LandmarkPrior{}, 0.1);
        step.unit = landmark.motion_in_metres ? 0.7 * unit_of_motion(models, y) : 0.0;
      }
      MotionPrior prior;
      prior.sigmas = MotionVector::LinSpaced(landmark.motion, 1.0, 2.5);
      prior.unit = landmark.motion_in_metres ? 0.3 : 0.0;
      expect_gradients(*motion_prior_cost(models, prior), {y, w});
      if (!lacks_infinity(landmark.point)) {  // so far away that the unit stays
        const SmallVector far = landmark.point.of({0.2, 0.1, 1.0}, 1e-4, Eigen::Vector3d::Zero());
        expect_gradients(*motion_prior_cost(models, prior), {far, w});
      }
      for (int depth = 1; depth <= 3; ++depth) {
        blocks.emplace_back(normals(landmark.dim(), 1.0));
        expect_gradients(*chain_pixel_cost(models, {{300, 200}, false}, chain, depth), blocks);
      }
    }
  }
}

}  // namespace
}  // namespace slammot
