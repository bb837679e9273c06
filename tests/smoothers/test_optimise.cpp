// Minimum and covariances of a small scene against those that Ceres finds.
#include <ceres/covariance.h>
#include <ceres/problem.h>
#include <gtest/gtest.h>

#include <random>

#include "estimation/estimator.h"
#include "models/camera_motion.h"
#include "smoothers/graph/camera_manifold.h"
#include "smoothers/graph/factors.h"
#include "smoothers/solver/ceres_solve.h"
#include "smoothers/solver/optimise.h"
#include "tests/smoothers/fixture.h"

namespace slammot {
namespace {

// Three cameras, eight static landmarks anchored at the first: enough for every kind of block.
struct SmallScene {
  MotionManifold manifold;
  Graph graph{false};
  std::vector<VariableId> positions, motions, ys;

  SmallScene() {
    std::mt19937_64 engine(7);
    std::normal_distribution<double> normal;
    InitialCamera initial;
    initial.state = test::camera_at(0.0, 0.0);
    initial.position_sigma = initial.rotation_sigma = 0.01;
    for (int i = 0; i < 3; ++i) {
      Eigen::VectorXd position(3), motion(kMotionSize);
      camera_to_blocks(test::camera_at(0.3 * i, 0.05 * i), position.data(), motion.data());
      positions.push_back(graph.add_variable(position, nullptr, -1));
      motions.push_back(graph.add_variable(motion, &manifold, -1));
    }
    graph.add_factor({positions[0], motions[0]}, initial_camera_cost(initial));
    MotionNoise noise{2.0, 1.0};
    for (std::size_t i = 1; i < 3; ++i) {
      graph.add_factor({positions[i - 1], motions[i - 1], positions[i], motions[i]},
                       camera_motion_cost(camera_noise(noise, initial.state, 0.3), 0.3));
    }
    for (int l = 0; l < 8; ++l) {
      const Eigen::Vector3d y(0.1 * normal(engine), 0.1 * normal(engine), 0.2);
      ys.push_back(graph.add_variable(y, nullptr, l));
      graph.add_factor({ys.back()}, inverse_depth_prior_cost({0.2, 0.05, 2.0}));
      for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Vector2d z(320.0 + 40.0 * normal(engine) - 25.0 * static_cast<double>(i),
                                240.0 + 40.0 * normal(engine));
        if (i == 0) {
          graph.add_factor({motions[0], ys.back()}, first_pixel_cost(test::pinhole(), z, 30.0));
        } else {
          graph.add_factor({positions[i], motions[i], positions[0], ys.back()},
                           pixel_cost(test::pinhole(), z, 30.0));
        }
      }
    }
  }
};

TEST(NormalEquations, CovariancesAreThoseOfCeres) {
  SmallScene scene;
  optimise(scene.graph, 50, 1e-20);
  scene.graph.linearise();
  const std::vector<std::vector<VariableId>> sets{{scene.positions[2], scene.motions[2]},
                                                  {scene.positions[0], scene.ys[3]}};
  const auto P = NormalEquations(scene.graph).covariances(sets);
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  for (const auto& [id, v] : scene.graph.variables()) {
    problem.AddParameterBlock(scene.graph.variable(id).value.data(),
                              static_cast<int>(v.value.size()),
                              const_cast<ceres::Manifold*>(v.manifold));
  }
  for (const auto& [id, f] : scene.graph.factors()) {
    std::vector<double*> blocks;
    for (const VariableId v : f.variables) blocks.push_back(scene.graph.variable(v).value.data());
    problem.AddResidualBlock(f.cost.get(), nullptr, blocks);
  }
  ceres::Covariance::Options dense;
  dense.algorithm_type = ceres::DENSE_SVD;
  ceres::Covariance oracle(dense);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    std::vector<const double*> blocks;
    for (const VariableId id : sets[k]) blocks.push_back(scene.graph.variable(id).value.data());
    ASSERT_TRUE(oracle.Compute(blocks, &problem));
    Eigen::Matrix<double, -1, -1, Eigen::RowMajor> expected(P[k].rows(), P[k].cols());
    ASSERT_TRUE(oracle.GetCovarianceMatrixInTangentSpace(blocks, expected.data()));
    EXPECT_LT((P[k] - expected).norm(), 1e-9 * expected.norm());
  }
}

TEST(Optimise, CeresEndsWhereItWasAllowedTo) {
  SmallScene scene;
  EXPECT_THROW(solve_with_ceres(scene.graph, 1), Diverged);
  EXPECT_GT(solve_with_ceres(scene.graph, 200).iterations, 1);
}

TEST(Optimise, FindsTheMinimumThatCeresFinds) {
  SmallScene ours, theirs;
  optimise(ours.graph, 50, 1e-20);
  solve_with_ceres(theirs.graph, 200);
  const NormalEquations equations(ours.graph);
  for (const auto& [id, v] : ours.graph.variables()) {
    const std::vector<std::vector<VariableId>> own{{id}};
    const Eigen::VectorXd sigma = equations.covariances(own).front().diagonal().cwiseSqrt();
    const Eigen::VectorXd d = minus(v.manifold, v.value, theirs.graph.value(id));
    EXPECT_LT(d.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 1e-4) << id;
  }
}

}  // namespace
}  // namespace slammot
