// Minimum and covariances of a scene against those that Ceres finds.
#include <ceres/covariance.h>
#include <gtest/gtest.h>

#include "estimation/estimator.h"
#include "smoothers/ceres/ceres_solve.h"
#include "smoothers/solver/optimise.h"
#include "tests/smoothers/fixture/dense.h"
#include "tests/smoothers/fixture/posterior.h"
#include "tests/smoothers/fixture/scene.h"

namespace slammot {
namespace {

using test::Scene;

TEST(Optimise, FindsTheMinimumThatCeresFinds) {
  Scene ours(15), theirs(15);
  for (Scene* scene : {&ours, &theirs}) {
    scene->hold({scene->graph[Scene::kPlain].y, scene->cameras[0].orientation,
                 scene->graph[Scene::kMoving].y, scene->graph[Scene::kMoving].w});
    scene->move();
  }
  Optimiser optimiser;
  optimiser(ours.graph, ours.newest(), 200, 1e-20);
  solve_with_ceres(theirs.graph, 500);
  const Eigen::VectorXd sigma = test::dense_problem(ours.graph).covariance().diagonal().cwiseSqrt();
  const test::Columns columns(ours.graph);
  ours.graph.variables.for_each([&](const Variable& v) {
    const Eigen::VectorXd d = minus(v.is_orientation, v.value, theirs.graph.variables[v.id].value);
    const Eigen::VectorXd of_v = sigma.segment(columns.of(v.id), v.dim());
    EXPECT_LT(d.cwiseQuotient(of_v).cwiseAbs().maxCoeff(), 1e-4) << v.id;
  });
  for (const LandmarkId id : {Scene::kMoving, Scene::kFreed}) {
    for (std::size_t k = 0; k < ours.graph[id].chain.size(); ++k) {
      const LandmarkVector d = ours.graph[id].chain[k].noise - theirs.graph[id].chain[k].noise;
      EXPECT_LT(d.cwiseAbs().maxCoeff(), 1e-4);
    }
  }
}

// Of camera, anchor and newest state, as NormalEquations::joint(). Ceres has the base and the
// noises.
Eigen::MatrixXd joint_of_ceres(Scene& scene, LandmarkId id) {
  Graph& graph = scene.graph;
  const GraphLandmark& l = graph[id];
  std::vector<const double*> blocks;
  for (const VariableId variable :
       {scene.newest().position, scene.newest().orientation, scene.newest().rates, l.anchor, l.y}) {
    blocks.push_back(graph.variables[variable].value.data());
  }
  if (l.is_free()) blocks.push_back(graph.variables[l.w].value.data());
  const Eigen::Index dim = l.is_free() ? graph.models().landmark->dim() : 3, state = 15;
  Eigen::Index total = state + dim;
  Eigen::MatrixXd newest = Eigen::MatrixXd::Zero(dim, total + dim * l.steps());
  newest.middleCols(state, dim).setIdentity();
  for (const ChainStep& step : l.chain) {
    newest = (step.F * newest).eval();
    newest.middleCols(total, dim) = step.G;
    blocks.push_back(step.noise.data());
    total += dim;
  }
  const CeresProblem built = ceres_problem(graph);
  ceres::Covariance::Options dense;
  dense.algorithm_type = ceres::DENSE_SVD;
  ceres::Covariance oracle(dense);
  EXPECT_TRUE(oracle.Compute(blocks, built.problem.get()));
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> covariance(total, total);
  EXPECT_TRUE(oracle.GetCovarianceMatrixInTangentSpace(blocks, covariance.data()));
  Eigen::MatrixXd E = Eigen::MatrixXd::Identity(state + dim, total);
  E.bottomRows(dim) = newest;
  return E * covariance * E.transpose();
}

// Without a prior, with that of a frame that has left, and with a mover that has become static.
TEST(Optimise, CovariancesAreThoseOfCeres) {
  for (const int leaves : {0, 1, 2}) {
    Scene scene(16);
    Graph& graph = scene.graph;
    if (leaves > 0) scene.marginalise(scene.oldest_leaves());
    if (leaves > 1) {
      Leaving dropped;
      dropped.departures = {scene.drop(Scene::kMoving)};
      scene.marginalise(dropped);
      ASSERT_FALSE(graph[Scene::kMoving].is_free());
    }
    Optimiser optimiser;
    optimiser(graph, scene.newest(), 200, 1e-20);
    graph.linearise();
    NormalEquations equations;
    equations.factorise(graph, scene.newest());
    const std::vector<LandmarkId> landmarks{Scene::kPlain, Scene::kMoving, Scene::kFreed};
    equations.prepare(graph, landmarks);
    for (const LandmarkId id : landmarks) {
      EXPECT_LT(test::difference(equations.joint(id), joint_of_ceres(scene, id)), 1e-9)
          << id << ' ' << leaves;
    }
  }
}

// Those that the optimiser has kept are of its last linearisation, a vanishing step away.
TEST(Optimise, KeepsTheCovarianceOfItsLastLinearisation) {
  Scene scene(16);
  Optimiser optimiser;
  optimiser(scene.graph, scene.newest(), 200, 1e-20);
  scene.graph.linearise();
  EXPECT_LT(test::difference(optimiser.equations().camera_covariance(),
                             joint_of_ceres(scene, Scene::kPlain).topLeftCorner(12, 12)),
            1e-6);
}

TEST(Optimise, CeresEndsWhereItWasAllowedTo) {
  Scene scene(17);
  EXPECT_FALSE(solve_with_ceres(scene.graph, 1).has_converged);
  EXPECT_GT(solve_with_ceres(scene.graph, 200).iterations, 1);
}

// A measurement that cannot be evaluated where Ceres begins is left out, and counted.
TEST(Optimise, CeresLeavesOutWhatIsBehind) {
  Scene scene(18);
  EXPECT_EQ(ceres_problem(scene.graph).waiting, 0);
  scene.graph.variables[scene.graph[Scene::kKnown].y].value(0) += 3.0;
  EXPECT_EQ(ceres_problem(scene.graph).waiting, 2);
}

// Far from the minimum the step of Gauss-Newton raises the cost. It is damped when there is more
// than one iteration, and taken as it is when there is one, as in an EKF.
TEST(Optimise, DampsAStepThatRaisesTheCost) {
  for (unsigned seed = 1;; ++seed) {
    ASSERT_LT(seed, 100u) << "no such scene";
    Scene scene(seed);
    scene.move(10.0);
    Graph& graph = scene.graph;
    const double before = graph.linearise();
    const Eigen::VectorXd dx = test::dense_problem(graph).step();
    test::set_steps(graph, dx);
    if (graph.try_step().cost() <= before) continue;
    Scene once(seed);
    once.move(10.0);
    Optimiser()(once.graph, once.newest(), 1, 1e-20);
    EXPECT_LT((test::steps_of(once.graph) - dx).norm(), 1e-9 * dx.norm());
    EXPECT_GT(once.graph.linearise(), before);
    double cost = before;
    Optimiser optimiser;
    for (int i = 0; i < 5; ++i) {  // the last of its iterations is not damped, but refused
      optimiser(graph, scene.newest(), 2, 1e-20);
      const double after = graph.linearise();
      EXPECT_LE(after, cost);
      cost = after;
    }
    EXPECT_LT(cost, 0.5 * before);
    return;
  }
}

// So is the single step after a label has changed: a mover that is released may be thrown behind
// the camera by it, where nothing brings it back.
TEST(Optimise, HalvesASingleStepThatRaisesTheCost) {
  for (unsigned seed = 1;; ++seed) {
    ASSERT_LT(seed, 100u) << "no such scene";
    Scene scene(seed), every(seed);
    for (Scene* s : {&scene, &every}) s->move(10.0);
    const double before = scene.graph.linearise();
    every.graph.linearise();
    Optimiser(StepRule::kEvery).take_step(every.graph, every.newest());
    if (every.graph.linearise() <= before) continue;
    Optimiser().take_step(scene.graph, scene.newest());
    EXPECT_LT(scene.graph.linearise(), before);
    return;
  }
}

// Also with first estimates, where the Jacobians are not those of the cost; with StepRule::kEvery
// every step is taken.
TEST(Optimise, DampsAStepThatRaisesTheCostWithFixedPoints) {
  for (unsigned seed = 1;; ++seed) {
    ASSERT_LT(seed, 100u) << "no such scene";
    Scene scene(seed, {test::kModel, true}), every(seed, {test::kModel, true});
    for (Scene* s : {&scene, &every}) {
      s->marginalise(s->oldest_leaves());
      s->move(10.0);
    }
    const double before = scene.graph.linearise();
    test::set_steps(scene.graph, test::stored_problem(scene.graph).step());
    if (scene.graph.try_step().cost() <= before) continue;
    Optimiser(StepRule::kEvery)(every.graph, every.newest(), 2, 1e20);
    EXPECT_GT(every.graph.linearise(), before);
    Optimiser()(scene.graph, scene.newest(), 5, 1e-20);
    EXPECT_LT(scene.graph.linearise(), before);
    return;
  }
}

// The next step would change residuals by about the tolerance; five times as much is allowed, since
// the curvature of large residuals adds to it.
TEST(Optimise, LeavesAboutItsTolerance) {
  constexpr double kTolerance = 1e-3;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Scene scene(seed);
    scene.move(1.0);
    Graph& graph = scene.graph;
    Optimiser()(graph, scene.newest(), 50, kTolerance);
    const double before = graph.linearise();
    test::set_steps(graph, test::dense_problem(graph).step());
    const StepOutcome next = graph.try_step();
    EXPECT_LT(before - next.cost(), next.cost_of(5.0 * kTolerance)) << "seed " << seed;
  }
}

TEST(Optimise, EndsWhenLittleIsToBeGained) {
  Scene scene(19), other(19);
  Optimiser()(scene.graph, scene.newest(), 50, 1e20);  // one step
  Optimiser().take_step(other.graph, other.newest());
  scene.graph.variables.for_each(
      [&](const Variable& v) { EXPECT_EQ(v.value, other.graph.variables[v.id].value); });
}

}  // namespace
}  // namespace slammot
