// What the graph stores of its linearisation, and how a step carries it along, against Ceres.
#include <gtest/gtest.h>

#include "tests/smoothers/fixture/dense.h"
#include "tests/smoothers/fixture/scene.h"

namespace slammot {
namespace {

using test::Scene;

// Variables of every kind, not in the order of their slots.
std::vector<VariableId> some_of_all(const Scene& scene) {
  const Graph& graph = scene.graph;
  return {graph[Scene::kFreed].y,      scene.cameras[1].orientation, graph[Scene::kPlain].y,
          scene.cameras[0].position,   graph[Scene::kMoving].y,      graph[Scene::kMoving].w,
          scene.cameras[1].rates,      graph.scene->scene,           scene.cameras[1].position,
          scene.cameras[0].orientation};
}

struct GraphLinearisation : testing::TestWithParam<std::tuple<test::Model, bool>> {
  GraphLinearisation() : scene(3, {std::get<0>(GetParam())}) {
    if (std::get<1>(GetParam())) {
      scene.hold(some_of_all(scene));
      scene.move(5.0);
    }
  }
  Scene scene;
};

// Its derivatives are tested in test_cost_functions.cpp.
TEST_P(GraphLinearisation, IsThatOfCeres) {
  const double cost = scene.graph.linearise();
  const test::DenseProblem expected = test::dense_problem(scene.graph);
  const test::DenseProblem stored = test::stored_problem(scene.graph);
  ASSERT_EQ(stored.r.size(), expected.r.size());
  EXPECT_NEAR(cost, expected.cost, 1e-12 * cost);
  EXPECT_LT((stored.r - expected.r).norm(), 1e-11 * expected.r.norm());
  for (Eigen::Index i = 0; i < stored.J.rows(); ++i) {
    EXPECT_LT((stored.J.row(i) - expected.J.row(i)).norm(), 1e-11 * expected.J.row(i).norm())
        << "row " << i;
  }
}

TEST_P(GraphLinearisation, CostAfterAStepIsThatOfCeres) {
  Graph& graph = scene.graph;
  test::set_steps(graph, 0.01 * Eigen::VectorXd::Random(test::Columns(graph).size()));
  const double here = graph.linearise(), cost = graph.try_step().cost();
  EXPECT_EQ(graph.linearise(), here);  // nothing has moved
  graph.retract();
  EXPECT_NEAR(cost, test::dense_problem(graph).cost, 1e-12 * cost);
  EXPECT_NEAR(cost, graph.linearise(), 1e-12 * cost);
}

// r(x [+] dx) - (r + J dx). The prior and first camera are not among them: with the scene's small
// step they differ by less than the tolerance.
TEST_P(GraphLinearisation, LinearisationErrorIsWhatTheStepLeaves) {
  Graph& graph = scene.graph;
  const test::DenseProblem at = test::stored_problem(graph);
  const Eigen::VectorXd dx = 0.01 * Eigen::VectorXd::Random(at.J.cols());
  test::set_steps(graph, dx);
  const double error = graph.try_step().error_square;
  graph.retract();
  graph.linearise();
  const double expected = (test::stored_problem(graph).r - (at.r + at.J * dx)).squaredNorm();
  EXPECT_GT(expected, 1e-8);
  EXPECT_NEAR(error, expected, 0.05 * expected);
}

// r + J dx, and J in the tangent spaces of the new estimate. The prior is evaluated where it is.
TEST_P(GraphLinearisation, GoesAlongWithAStep) {
  Graph& graph = scene.graph;
  const test::DenseProblem before = test::stored_problem(graph);
  const Eigen::VectorXd dx = 0.1 * Eigen::VectorXd::Random(before.J.cols());
  test::set_steps(graph, dx);
  std::vector<std::pair<VariableId, Eigen::Vector3d>> turns;
  graph.variables.for_each([&](const Variable& v) {
    if (v.is_orientation) turns.emplace_back(v.id, Eigen::Vector3d(v.step));
  });
  graph.retract();
  const test::DenseProblem after = test::stored_problem(graph);
  Eigen::MatrixXd J = before.J;
  for (const auto& [id, turn] : turns) {
    const int column = before.columns.of(id);
    J.middleCols<3>(column) = (J.middleCols<3>(column) * inverse_right_jacobian_so3(turn)).eval();
  }
  const Eigen::Index rows = before.r.size() - graph.prior().active.r().size();
  const Eigen::VectorXd r = before.r + before.J * dx;
  EXPECT_LT((after.r - r).head(rows).norm(), 1e-12 * r.norm());
  EXPECT_LT((after.J - J).topRows(rows).norm(), 1e-12 * J.norm());
  const test::DenseProblem anew = test::dense_problem(graph);
  EXPECT_LT((after.r - anew.r).tail(r.size() - rows).norm(), 1e-11 * r.norm());
  EXPECT_LT((after.J - anew.J).bottomRows(r.size() - rows).norm(), 1e-11 * J.norm());
  for (const LandmarkId id : {Scene::kMoving, Scene::kFreed}) {
    EXPECT_LT((graph[id].chain.back().x - graph.newest_state(graph[id])).norm(), 1e-14);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, GraphLinearisation,
                         testing::Combine(testing::ValuesIn(test::every_model()), testing::Bool()));

// A landmark that has been at rest all the time: its measurements are those of one point, and are
// linearised as such.
TEST(Graph, ConditionedOnRest) {
  for (const bool is_in_prior : {false, true}) {
    Scene scene(4);
    Graph& graph = scene.graph;
    if (is_in_prior) {
      scene.hold({graph[Scene::kMoving].w, graph[Scene::kMoving].y, scene.cameras[0].position});
      scene.move();
    }
    const Eigen::Index size = test::Columns(graph).size();
    graph.constrain_to_rest(Scene::kMoving, 0.0);
    graph.forget_motion(Scene::kMoving);
    const GraphLandmark& l = graph[Scene::kMoving];
    EXPECT_FALSE(l.is_free());
    EXPECT_EQ(l.pixels.size(), 5u);
    EXPECT_EQ(test::Columns(graph).size(), size - 3 - 4 * 6);
    const test::DenseProblem stored = test::stored_problem(graph);
    const test::DenseProblem expected = test::dense_problem(graph);
    EXPECT_LT((stored.r - expected.r).norm(), 1e-11 * expected.r.norm());
    EXPECT_LT((stored.J - expected.J).norm(), 1e-11 * expected.J.norm());
  }
}

// J_w of a landmark at rest: by how much its pixel would move, had it moved since with w.
TEST(Graph, JacobianOfAConstrainedMotion) {
  for (const test::Model& model : test::models()) {
    Scene scene(4, {model});
    Graph& graph = scene.graph;
    const LandmarkFunctions& functions = *graph.models().landmark;
    GraphLandmark& l = graph[Scene::kMoving];
    double time = 7.0;
    for (GraphPixel& pixel : l.pixels) pixel.time = time += 0.4;
    const double rest_time = 7.9;  // between the first frame and the second but one
    graph.constrain_to_rest(Scene::kMoving, rest_time);
    graph.linearise();
    const Eigen::Vector3d y = graph.variables[l.y].value;
    for (const GraphPixel& pixel : l.pixels) {
      const auto residual = [&](const MotionVector& w) -> Eigen::Vector2d {
        const double dt = std::max(0.0, pixel.time - rest_time);
        const LandmarkVector moved = functions.predict(landmark_state(y, w), dt);
        return pixel_residual(graph.models(), pixel.z, graph.variables[pixel.position].value,
                              quaternion(graph.variables[pixel.orientation].value),
                              graph.variables[l.anchor].value, moved.head<3>())
            .value()
            .r;
      };
      ASSERT_EQ(pixel.J_w.cols(), functions.motion);
      EXPECT_EQ(pixel.J_w.norm() > 0.0, pixel.time > rest_time);
      constexpr double kStep = 1e-5;
      for (int i = 0; i < functions.motion; ++i) {
        const MotionVector w = kStep * MotionVector::Unit(functions.motion, i);
        const Eigen::Vector2d numeric = (residual(w) - residual(-w)) / (2.0 * kStep);
        EXPECT_LT((numeric - pixel.J_w.col(i)).norm(), 1e-6 * std::max(1.0, pixel.J_w.norm()))
            << model << ", " << i;
      }
    }
  }
}

// It goes where J_y goes: a step does not take it anew, and a prior holds the same number.
TEST(Graph, JacobianOfAConstrainedMotionIsOfTheLinearisation) {
  Scene scene(4);
  Graph& graph = scene.graph;
  GraphLandmark& l = graph[Scene::kMoving];
  double time = 0.0;
  for (GraphPixel& pixel : l.pixels) pixel.time = time += 0.4;
  graph.constrain_to_rest(Scene::kMoving, 0.3);
  graph.linearise();
  const auto J_w = l.pixels.front().J_w;
  test::set_steps(graph, 0.01 * Eigen::VectorXd::Random(test::Columns(graph).size()));
  graph.retract();
  EXPECT_EQ(l.pixels.front().J_w, J_w);
  const VariableId w = l.constrained->w;
  Leaving leaving = scene.oldest_leaves();
  std::erase_if(leaving.departures,
                [](const Departure& d) { return d.landmark != Scene::kMoving; });
  leaving.oldest.reset();
  leaving.departures.front() = {};
  leaving.departures.front().landmark = Scene::kMoving;
  leaving.departures.front().until = 0.4;
  MotionVector information = l.constrained->prior.sigmas.cwiseAbs2().cwiseInverse();
  scene.marginalise(leaving);
  const MarginalPrior& prior = graph.prior().active;
  const MarginalPrior::Block* block = prior.find(w);
  ASSERT_NE(block, nullptr);
  const Eigen::MatrixXd columns = prior.R().middleCols(block->offset, block->dim());
  Eigen::MatrixXd expected = J_w.transpose() * J_w;
  expected.diagonal() += information;
  EXPECT_LT((columns.transpose() * columns - expected).norm(), 1e-9 * expected.norm());
}

// A pixel behind its camera counts for nothing; a step that would put it there costs very much.
TEST(Graph, WhatIsBehindTheCamera) {
  Scene scene(4);
  Graph& graph = scene.graph;
  const double before = graph.linearise();
  test::set_steps(graph, Eigen::VectorXd::Zero(test::Columns(graph).size()));
  Variable& y = graph.variables[graph[Scene::kLone].y];
  y.step(0) = 3.0;
  EXPECT_GT(graph.try_step().cost(), before + 1e5);
  graph.retract();
  const GraphPixel& pixel = graph[Scene::kLone].pixels.front();
  EXPECT_TRUE(pixel.valid);
  graph.linearise();
  EXPECT_FALSE(pixel.valid);
  EXPECT_EQ(pixel.at.r.norm() + pixel.at.J_y.norm() + pixel.at.J_pose.norm(), 0.0);
}

}  // namespace
}  // namespace slammot
