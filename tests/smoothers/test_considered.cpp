// Considered landmarks: the core is what it would be had they never been measured, and they are
// what they are given the core.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "smoothers/solver/optimise.h"
#include "tests/smoothers/fixture/posterior.h"
#include "tests/smoothers/fixture/scene.h"

namespace slammot {
namespace {

using test::Scene;

struct Considered : testing::TestWithParam<test::Model> {
  // With the movers of a scene considered, and without them.
  Considered() : scene(21, {GetParam()}), without(21, {GetParam()}) {
    for (const LandmarkId id : {Scene::kMoving, Scene::kFreed}) {
      scene.graph.consider(id, true);
      without.graph.remove_landmark(id);
    }
  }

  // [sigma], and of covariances relative to their size.
  double difference_of_cores() {
    Optimiser ours, theirs;
    ours(scene.graph, scene.newest(), 100, 1e-12);
    theirs(without.graph, without.newest(), 100, 1e-12);
    const CameraState a = scene.graph.camera(scene.newest());
    const CameraState b = without.graph.camera(without.newest());
    const Matrix12d P = theirs.equations().camera_covariance();
    const Vector12d d = P.llt().matrixL().solve(boxminus(a, b));
    const double of_map = (scene.graph.value(scene.graph[Scene::kPlain].y) -
                           without.graph.value(without.graph[Scene::kPlain].y))
                              .norm();
    return std::max({d.norm(), of_map, test::difference(ours.equations().camera_covariance(), P)});
  }

  // Of camera, anchor and newest state of a mover, at the stored linearisation.
  Eigen::MatrixXd joint(LandmarkId id) {
    Optimiser optimiser;
    optimiser.factorise(scene.graph, scene.newest());
    optimiser.equations().prepare(scene.graph, std::span(&id, 1));
    return optimiser.equations().joint(id);
  }
  void linearise() {
    scene.graph.linearise();
    for (const LandmarkId id : {Scene::kMoving, Scene::kFreed}) {
      scene.graph.linearise(scene.graph[id]);
    }
  }

  Scene scene, without;
};

TEST_P(Considered, DoNotChangeTheCoreNorEnterItsPrior) {
  for (int i = 0; i < 3; ++i) {
    ASSERT_LT(difference_of_cores(), i == 0 ? 1e-9 : 1e-8) << i;
    scene.marginalise(scene.oldest_leaves());
    without.marginalise(without.oldest_leaves());
  }
  EXPECT_LT(difference_of_cores(), 1e-8);
  ASSERT_NE(scene.graph.prior().active.find(scene.graph[Scene::kMoving].w), nullptr);
}

// A step of the core is not theirs, whatever an earlier solution has left in their chains.
TEST_P(Considered, StayWhereTheyAreWhileTheCoreMoves) {
  GraphLandmark& l = scene.graph[Scene::kMoving];
  ASSERT_GT(l.steps(), 0);
  scene.graph.linearise();
  NormalEquations equations;
  equations.factorise(scene.graph, scene.newest());
  for (ChainStep& step : l.chain) step.step.setConstant(step.noise.size(), 1.0);
  equations.solve(scene.graph);
  const SmallVector y = scene.graph.variables[l.y].value;
  std::vector<LandmarkVector> noises;
  for (const ChainStep& step : l.chain) noises.push_back(step.noise);
  scene.graph.retract();
  EXPECT_EQ(scene.graph.variables[l.y].value, y);
  for (std::size_t i = 0; i < noises.size(); ++i) EXPECT_EQ(l.chain[i].noise, noises[i]) << i;
}

// The tests above can fail: movers that are not considered do change it.
TEST_P(Considered, OthersDo) {
  for (const LandmarkId id : {Scene::kMoving, Scene::kFreed}) scene.graph.consider(id, false);
  EXPECT_GT(difference_of_cores(), 1e-3);
}

// P_cc of the others, and p(o | core) of its own rows: with A = do/d(core) the marginal of o is
// A P_cc A' + (J_o' J_o)^-1.
TEST_P(Considered, AreWhatTheyAreGivenTheCore) {
  constexpr LandmarkId kId = Scene::kMoving;
  scene.graph.consider(Scene::kFreed, false);
  linearise();
  const Eigen::MatrixXd ours = joint(kId);
  Scene all(21, {GetParam()});
  const test::DenseProblem dense = test::stored_problem(all.graph);
  const GraphLandmark& l = all.graph[kId];
  std::vector<int> own, core;
  const int motion = all.graph.models().landmark->motion;
  for (int k = 0; k < 3; ++k) own.push_back(dense.columns.of(l.y) + k);
  for (int k = 0; k < motion; ++k) own.push_back(dense.columns.of(l.w) + k);
  for (int i = 0; i < l.steps(); ++i) {
    for (int k = 0; k < 3 + motion; ++k) own.push_back(dense.columns.of_noise(kId, i) + k);
  }
  for (int i = 0; i < dense.columns.size(); ++i) {
    if (std::ranges::find(own, i) == own.end()) core.push_back(i);
  }
  std::vector<int> own_rows, others;
  for (int i = 0; i < dense.J.rows(); ++i) {
    (dense.J(i, own).norm() > 0.0 ? own_rows : others).push_back(i);
  }
  const Eigen::MatrixXd J_c = dense.J(others, core), J_o = dense.J(own_rows, own);
  const Eigen::MatrixXd P_cc = (J_c.transpose() * J_c).inverse();
  const Eigen::MatrixXd P_own = (J_o.transpose() * J_o).inverse();
  const Eigen::MatrixXd A = -P_own * J_o.transpose() * dense.J(own_rows, core);
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(dense.J.cols(), dense.J.cols());
  P(core, core) = P_cc;
  P(own, core) = A * P_cc;
  P(core, own) = P_cc * A.transpose();
  P(own, own) = A * P_cc * A.transpose() + P_own;
  const Eigen::MatrixXd M = dense.columns.joint_rows(all.graph, all.newest(), kId);
  EXPECT_LT(test::difference(ours, M * P * M.transpose()), 1e-6);
}

// What leaves the window is not lost to them. Measured again in the window, they say something of
// the pose that leaves (considered_marginal.h), so that here they are not.
TEST_P(Considered, StayAsKnownAsTheyWereWhenTheOldestFrameLeaves) {
  Optimiser optimiser;
  optimiser(scene.graph, scene.newest(), 100, 1e-12);
  for (const LandmarkId id : {Scene::kMoving, Scene::kFreed}) {
    std::vector<GraphPixel>& pixels = scene.graph[id].pixels;
    pixels.erase(pixels.begin() + 1, pixels.end());
  }
  for (int i = 0; i < 3; ++i) {
    linearise();
    const Eigen::MatrixXd moving = joint(Scene::kMoving), freed = joint(Scene::kFreed);
    scene.marginalise(scene.oldest_leaves());
    EXPECT_LT(test::difference(joint(Scene::kMoving), moving), 1e-6) << i;
    EXPECT_LT(test::difference(joint(Scene::kFreed), freed), 1e-6) << i;
  }
}

// One that the prior holds with the rest is set apart: nothing that was known is lost.
TEST_P(Considered, AreSetApartFromAPrior) {
  scene.graph.consider(Scene::kMoving, false);
  scene.marginalise(scene.oldest_leaves());
  GraphLandmark& l = scene.graph[Scene::kMoving];
  ASSERT_NE(scene.graph.prior().active.find(l.w), nullptr);
  l.pixels.clear();  // those of a considered landmark say nothing of the core
  scene.graph.linearise();
  const Eigen::MatrixXd before = joint(Scene::kMoving);
  Leaving leaving;
  leaving.apart = Scene::kMoving;
  scene.marginalise(leaving);
  scene.graph.consider(Scene::kMoving, true);
  EXPECT_LT(test::difference(joint(Scene::kMoving), before), 1e-6);
  scene.graph.consider(Scene::kMoving, false);
  EXPECT_LT(test::difference(joint(Scene::kMoving), before), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Models, Considered, testing::ValuesIn(test::every_model()));

}  // namespace
}  // namespace slammot
