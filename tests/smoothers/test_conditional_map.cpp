// The inactive map: to deactivate, go on and reactivate changes nothing of the posterior.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "estimation/estimator.h"
#include "smoothers/solver/normal_equations.h"
#include "tests/smoothers/fixture/posterior.h"

namespace slammot {
namespace {

using test::Scene;

constexpr double kExact = 1e-8;  // [sigma]

// Frames 0 to 2 have left. With them `brief` fell asleep, then `lone`, then `known` and the anchor
// of both, while bases moved on along their chains, in the prior and out of it.
struct InactiveMap : testing::TestWithParam<test::Model> {
  InactiveMap() : scene(10, {GetParam()}), graph(scene.graph) {
    leave({graph[Scene::kBrief].y});
    leave({graph[Scene::kLone].y});
    leave({graph[Scene::kKnown].y, anchor()});
  }
  VariableId anchor() const { return scene.cameras[1].position; }
  void expect_exact(const Leaving& leaving) {
    EXPECT_LT(test::change_by_marginalising(scene, leaving), kExact);
    scene.move(3.0);
  }
  void leave(const std::vector<VariableId>& deactivated) {
    Leaving leaving = scene.oldest_leaves();
    leaving.deactivated = deactivated;
    expect_exact(leaving);
    for (const VariableId id : deactivated) {
      EXPECT_FALSE(graph.variables[id].is_active);
      EXPECT_FALSE(graph.prior().active.find(id));
    }
  }
  test::Posterior posterior(const test::Asked& asked) {
    return test::posterior(graph, test::dense_problem(graph), asked);
  }
  Scene scene;
  Graph& graph;
};

TEST_P(InactiveMap, HasItsMarginals) {
  EXPECT_EQ(graph.prior().inactive.dim(), 12);
  NormalEquations equations;
  equations.factorise(graph, scene.newest());
  const std::vector<LandmarkId> asleep{Scene::kBrief, Scene::kLone, Scene::kKnown};
  equations.prepare(graph, asleep);
  for (const LandmarkId id : asleep) {
    const test::Asked asked{{scene.newest().position, scene.newest().orientation,
                             scene.newest().rates, graph[id].anchor, graph[id].y},
                            {}};
    const test::Posterior expected = posterior(asked);
    EXPECT_EQ(equations.state_dim(graph, id), 3);
    EXPECT_LT(test::difference(equations.joint(id), expected.covariance), 1e-9) << id;
  }
}

// The estimate of an inactive variable follows the active ones.
TEST_P(InactiveMap, FollowsTheStep) {
  const VariableId y = graph[Scene::kLone].y;
  const test::Asked asked{{y}, {}};
  const test::DenseProblem problem = test::dense_problem(graph);
  const Eigen::VectorXd expected = test::posterior(graph, problem, asked).mean;
  graph.prior().relinearise();  // so that the step and b [-] b0 are the same
  test::set_steps(graph, problem.step());
  graph.retract();
  EXPECT_LT((graph.value(y) - expected).norm(), 1e-10);
}

TEST_P(InactiveMap, RelinearisedOrReactivatedItIsTheSame) {
  const test::Asked all = test::what_stays(graph, {});
  const test::Posterior before = posterior(all);
  graph.prior().relinearise();
  EXPECT_EQ(graph.prior().active.difference().norm(), 0.0);
  EXPECT_LT(test::difference(posterior(all), before), kExact);
  graph.reactivate({graph[Scene::kLone].y, anchor()});
  EXPECT_EQ(graph.prior().inactive.dim(), 6);
  EXPECT_TRUE(graph.variables[anchor()].is_active);
  graph.linearise();
  EXPECT_LT(test::difference(posterior(all), before), kExact);
  graph.reactivate({graph[Scene::kKnown].y, graph[Scene::kBrief].y});
  EXPECT_TRUE(graph.prior().inactive.empty());
  graph.linearise();
  EXPECT_LT(test::difference(posterior(all), before), kExact);
}

// Back in sight, measured anew, and left behind once more; what sleeps hangs on what has woken.
TEST_P(InactiveMap, GoesOnAfterReactivation) {
  graph.reactivate({graph[Scene::kLone].y, anchor()});
  graph.add_pixel(Scene::kLone, scene.cameras[3], {0, {330.0, 250.0}}, 0);
  graph.linearise();
  leave({graph[Scene::kLone].y});
  Leaving leaving;
  leaving.departures = {scene.drop(Scene::kFreed), scene.drop(Scene::kMoving)};
  expect_exact(leaving);
  graph.reactivate({graph[Scene::kKnown].y, graph[Scene::kLone].y});
  EXPECT_EQ(graph.prior().inactive.dim(), 3);
  graph.linearise();
  leaving.clear();
  leaving.departures = {scene.all_of(Scene::kMoving)};
  expect_exact(leaving);
}

// Several steps of chains in the prior, while the map depends on them: two motions are forgotten,
// or one landmark leaves whole.
TEST_P(InactiveMap, WhileChainsLeave) {
  for (const bool is_whole : {false, true}) {
    Scene early(11, {GetParam()});
    Leaving leaving = early.oldest_leaves();
    leaving.deactivated = {early.graph[Scene::kBrief].y};
    EXPECT_LT(test::change_by_marginalising(early, leaving), kExact);
    early.move();
    EXPECT_GT(early.graph.prior()
                  .inactive.gain({early.graph[Scene::kBrief].y}, early.graph.prior().active.chart())
                  .norm(),
              1e-3);
    leaving.clear();
    if (is_whole) {
      ASSERT_GT(early.graph[Scene::kMoving].steps(), 1);
      leaving.departures = {early.all_of(Scene::kMoving)};
    } else {
      leaving.departures = {early.drop(Scene::kFreed), early.drop(Scene::kMoving)};
    }
    EXPECT_LT(test::change_by_marginalising(early, leaving), kExact);
  }
}

TEST_P(InactiveMap, ForgetsWhatIsMarginalised) {
  test::Asked asked = test::what_stays(graph, {});
  std::erase(asked.variables, graph[Scene::kLone].y);
  const test::Posterior before = posterior(asked);
  const VariableId y = graph[Scene::kLone].y;
  graph.prior().inactive.forget({y});
  graph.variables.remove(y);
  graph.remove_landmark(Scene::kLone);
  EXPECT_EQ(graph.prior().inactive.dim(), 9);
  EXPECT_FALSE(graph.prior().inactive.contains(y));
  EXPECT_EQ(test::difference(posterior(asked), before), 0.0);
  leave({});  // its rows of the map are vacant
}

// That a motion in the prior is zero: the posterior given that it is.
TEST_P(InactiveMap, ConditionedOnZero) {
  leave({});  // the chain has come to its end, and w is in the prior alone
  GraphLandmark& l = graph[Scene::kMoving];
  ASSERT_EQ(l.steps(), 0);
  test::Asked asked = test::what_stays(graph, {});
  std::erase_if(asked.states, [](const auto& s) { return s.landmark == Scene::kMoving; });
  asked.variables.push_back(l.y);
  const test::Posterior rest = posterior(asked);
  const Eigen::Index n = rest.mean.size(), m = graph.models().landmark->motion;
  test::Asked with_w = asked;
  with_w.states.push_back({Scene::kMoving, 0, static_cast<int>(m) + 3});
  const test::Posterior joint = posterior(with_w);
  const Eigen::MatrixXd P = joint.covariance;
  const Eigen::MatrixXd gain =
      P.bottomRightCorner(m, m).llt().solve(P.bottomLeftCorner(m, n)).transpose();
  const test::Posterior expected{joint.mean.head(n) - gain * joint.mean.tail(m),
                                 P.topLeftCorner(n, n) - gain * P.bottomLeftCorner(m, n)};
  EXPECT_GT(test::difference(rest, expected), 1e-3);

  graph.constrain_to_rest(Scene::kMoving, 0.0);
  graph.forget_motion(Scene::kMoving);
  EXPECT_FALSE(l.is_free());
  EXPECT_LT(test::difference(posterior(asked), expected), kExact);
}

INSTANTIATE_TEST_SUITE_P(Models, InactiveMap, testing::ValuesIn(test::every_model()));

TEST(ConditionalMap, WhatHasNoCovarianceDoesNotReturn) {
  ConditionalMap map;
  Variable x;
  x.value = Eigen::Vector3d::Ones();
  const MarginalPrior prior(false);
  map.relinearise(prior, 3);
  map.deactivate(x, 0);
  EXPECT_THROW(map.reactivate({x.id}, prior.chart()), Diverged);
}

}  // namespace
}  // namespace slammot
