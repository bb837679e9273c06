// The NIS of a measurement given all others, against its definition: without the measurement, the
// innovation and its covariance by a dense problem.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "smoothers/solver/given_others.h"
#include "smoothers/solver/optimise.h"
#include "tests/smoothers/fixture/dense.h"
#include "tests/smoothers/fixture/scene.h"

namespace slammot {
namespace {

using test::Scene;

// The row of pixel `i` of this landmark in the columns of all unknowns.
Eigen::MatrixXd row_of(const Graph& graph, const test::Columns& columns, LandmarkId id,
                       const GraphPixel& pixel) {
  Eigen::MatrixXd J = pixel.at.J_pose.leftCols<3>() * columns.rows(graph, pixel.position) +
                      pixel.at.J_pose.rightCols<3>() * columns.rows(graph, pixel.orientation);
  J += pixel.at.J_anchor * columns.rows(graph, graph[id].anchor);
  return J + pixel.at.J_y * columns.state_rows(graph, id, pixel.depth).topRows<3>();
}

// Of the stored linearisation, with the pixel left out of it.
double by_definition(Scene& scene, LandmarkId id, int i) {
  Graph& graph = scene.graph;
  const GraphPixel pixel = graph[id].pixels[static_cast<std::size_t>(i)];
  graph[id].pixels.erase(graph[id].pixels.begin() + i);
  const test::DenseProblem others = test::stored_problem(graph);
  graph[id].pixels.insert(graph[id].pixels.begin() + i, pixel);
  const Eigen::MatrixXd J = row_of(graph, others.columns, id, pixel);
  const Eigen::Vector2d nu = pixel.at.r + J * others.step();
  const Eigen::Matrix2d S = Eigen::Matrix2d::Identity() + J * others.covariance() * J.transpose();
  return nu.dot(S.inverse() * nu);
}

struct Held : testing::TestWithParam<bool> {};  // whether landmarks and cameras are in a prior

TEST_P(Held, NisIsThatOfTheInnovationGivenTheOthers) {
  Scene scene(21);
  Graph& graph = scene.graph;
  if (GetParam()) scene.marginalise(scene.oldest_leaves());
  graph.linearise();
  std::vector<double> expected;
  for (const LandmarkId id : {Scene::kPlain, Scene::kMoving, Scene::kFreed}) {
    for (int i = 1; i < std::ssize(graph[id].pixels); ++i) {
      expected.push_back(by_definition(scene, id, i));
    }
  }
  NormalEquations equations;
  equations.factorise(graph, scene.newest());
  equations.solve(graph);
  graph.retract();
  GivenOthers given_others;
  for (const LandmarkId id : {Scene::kPlain, Scene::kMoving, Scene::kFreed}) {
    for (int i = 1; i < std::ssize(graph[id].pixels); ++i) {
      const GraphPixel& pixel = graph[id].pixels[static_cast<std::size_t>(i)];
      given_others.add(equations, equations.block(id), i, pixel.at.r, true);
    }
  }
  const std::vector<double> nis = given_others.nis(equations);
  ASSERT_EQ(nis.size(), expected.size());
  for (std::size_t i = 0; i < nis.size(); ++i) EXPECT_NEAR(nis[i] / expected[i], 1.0, 1e-6) << i;
}

TEST_P(Held, SoItIsOfOneThatIsNotUsed) {
  for (const LandmarkId id : {Scene::kPlain, Scene::kMoving, Scene::kFreed}) {
    Scene scene(22);
    Graph& graph = scene.graph;
    if (GetParam()) scene.marginalise(scene.oldest_leaves());
    const GraphLandmark whole = graph[id];
    graph[id].pixels.erase(graph[id].pixels.begin() + 2);
    Optimiser optimiser;
    optimiser(graph, scene.newest(), 200, 1e-20);
    GraphLandmark entered = graph[id];
    entered.pixels.insert(entered.pixels.begin() + 2, whole.pixels[2]);
    graph.linearise(entered);
    LandmarkBlock block;
    block.eliminate(graph, entered, 0.0);
    GivenOthers given_others;
    given_others.add(optimiser.equations(), block, 2, block.weighed_residual(2), false);
    const double nis = given_others.nis(optimiser.equations()).front();
    graph[id] = entered;
    graph.linearise();
    EXPECT_NEAR(nis / by_definition(scene, id, 2), 1.0, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(OrNot, Held, testing::Bool());

}  // namespace
}  // namespace slammot
