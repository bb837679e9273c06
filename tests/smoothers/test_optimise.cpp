// The minimum of a scene against the one that Ceres finds, and steps that raise the cost. Of the
// covariances there: test_normal_equations.cpp.
#include <gtest/gtest.h>

#include <stdexcept>

#include "estimation/estimator.h"
#include "smoothers/ceres/ceres_solve.h"
#include "smoothers/solver/optimise.h"
#include "tests/smoothers/fixture/posterior.h"

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

// Those that the optimiser has kept are of its last linearisation, a vanishing step away.
TEST(Optimise, KeepsTheCovarianceOfItsLastLinearisation) {
  Scene scene(16);
  Optimiser optimiser;
  optimiser(scene.graph, scene.newest(), 200, 1e-20);
  scene.graph.linearise();
  const test::DenseProblem dense = test::dense_problem(scene.graph);
  const Eigen::MatrixXd M = dense.columns.rows(scene.graph, scene.newest());
  EXPECT_LT(test::difference(optimiser.equations().camera_covariance(),
                             M * dense.covariance() * M.transpose()),
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

// Far from its minimum, with and without first estimates, where Jacobians are not those of the
// cost.
struct Far : Scene {
  explicit Far(unsigned seed, bool fixed_points = false)
      : Scene(seed, {test::kModel, fixed_points}) {
    if (fixed_points) marginalise(oldest_leaves());
    move(10.0);
  }
};

// Of the first such scene in which the step of Gauss-Newton raises the cost.
unsigned seed_of_a_raise(bool fixed_points) {
  for (unsigned seed = 1; seed < 100; ++seed) {
    Far far(seed, fixed_points);
    const double before = far.graph.linearise();
    test::set_steps(far.graph, test::stored_problem(far.graph).step());
    if (far.graph.try_step().cost() > before) return seed;
  }
  throw std::logic_error("no such scene");
}

// It is damped when there is more than one iteration, and taken as it is when there is one, as in
// an EKF.
TEST(Optimise, DampsAStepThatRaisesTheCost) {
  const unsigned seed = seed_of_a_raise(false);
  Far once(seed), often(seed);
  const double before = once.graph.linearise();
  const Eigen::VectorXd dx = test::dense_problem(once.graph).step();
  Optimiser()(once.graph, once.newest(), 1, 1e-20);
  EXPECT_LT((test::steps_of(once.graph) - dx).norm(), 1e-9 * dx.norm());
  EXPECT_GT(once.graph.linearise(), before);
  double cost = before;
  Optimiser optimiser;
  for (int i = 0; i < 5; ++i) {  // the last of its iterations is not damped, but refused
    optimiser(often.graph, often.newest(), 2, 1e-20);
    const double after = often.graph.linearise();
    EXPECT_LE(after, cost);
    cost = after;
  }
  EXPECT_LT(cost, 0.5 * before);
}

// So is the single step after a label has changed: a mover that is released may be thrown behind
// the camera by it, where nothing brings it back. With StepRule::kEvery every step is taken.
TEST(Optimise, HalvesASingleStepThatRaisesTheCost) {
  const unsigned seed = seed_of_a_raise(false);
  Far halved(seed), every(seed);
  const double before = halved.graph.linearise();
  Optimiser().take_step(halved.graph, halved.newest());
  EXPECT_LT(halved.graph.linearise(), before);
  Optimiser(StepRule::kEvery).take_step(every.graph, every.newest());
  EXPECT_GT(every.graph.linearise(), before);
}

TEST(Optimise, DampsAStepThatRaisesTheCostWithFixedPoints) {
  const unsigned seed = seed_of_a_raise(true);
  Far damped(seed, true), every(seed, true);
  const double before = damped.graph.linearise();
  Optimiser()(damped.graph, damped.newest(), 5, 1e-20);
  EXPECT_LT(damped.graph.linearise(), before);
  Optimiser(StepRule::kEvery)(every.graph, every.newest(), 2, 1e20);
  EXPECT_GT(every.graph.linearise(), before);
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
