// To marginalise and then solve is to solve and then marginalise: what stays has the same mean and
// covariance before and after, whatever leaves.
#include <gtest/gtest.h>

#include "tests/smoothers/fixture/posterior.h"

namespace slammot {
namespace {

using test::Scene;

constexpr double kRounding = 1e-8;  // [sigma]

struct Marginalisation : testing::TestWithParam<test::Model> {
  Marginalisation() : scene(9, {GetParam()}), graph(scene.graph) {}
  void expect_exact(const Leaving& leaving) {
    EXPECT_LT(test::change_by_marginalising(scene, leaving), kRounding);
  }
  Scene scene;
  Graph& graph;
};

bool holds(const Graph& graph, VariableId id) { return graph.prior().active.find(id) != nullptr; }

// The oldest camera leaves with what it measured; the base of the chain in its frame moves on,
// first one of its own, then one that the prior holds.
TEST_P(Marginalisation, OfTheOldestFrame) {
  expect_exact(scene.oldest_leaves());
  EXPECT_FALSE(graph.initial);
  EXPECT_EQ(graph.motions.size(), 3u);
  EXPECT_EQ(graph[Scene::kMoving].steps(), 3);
  for (const LandmarkId id : {Scene::kPlain, Scene::kBrief, Scene::kMoving, Scene::kFreed}) {
    EXPECT_TRUE(holds(graph, graph[id].y)) << id;
  }
  EXPECT_TRUE(holds(graph, graph[Scene::kMoving].w));
  EXPECT_FALSE(holds(graph, graph[Scene::kFreed].w));  // its chain begins later
  expect_exact(scene.oldest_leaves());
  EXPECT_TRUE(holds(graph, graph[Scene::kFreed].w));
  EXPECT_EQ(graph[Scene::kFreed].steps(), 2);
  expect_exact(scene.oldest_leaves());
  EXPECT_EQ(graph.motions.size(), 1u);
}

// The estimate moves on between: orientations in the prior turn.
TEST_P(Marginalisation, OfFramesWhileTheEstimateMoves) {
  for (int i = 0; i < 3; ++i) {
    expect_exact(scene.oldest_leaves());
    scene.move(3.0);
  }
  expect_exact(scene.oldest_leaves());
}

// It is static from the end of its chain on: several steps at once, its motion forgotten. Of a
// landmark of its own, in the prior, or partly there.
TEST_P(Marginalisation, OfAMotion) {
  Scene early(9, {GetParam()});
  Leaving leaving;
  leaving.departures = {early.drop(Scene::kMoving)};
  EXPECT_LT(test::change_by_marginalising(early, leaving), kRounding);
  EXPECT_FALSE(early.graph[Scene::kMoving].is_free());
  EXPECT_EQ(early.graph[Scene::kMoving].steps(), 0);
  EXPECT_TRUE(early.graph[Scene::kMoving].pixels.empty());

  expect_exact(scene.oldest_leaves());
  ASSERT_TRUE(holds(graph, graph[Scene::kMoving].w) && holds(graph, graph[Scene::kFreed].y));
  ASSERT_FALSE(holds(graph, graph[Scene::kFreed].w));
  for (const LandmarkId id : {Scene::kMoving, Scene::kFreed}) {
    scene.move();
    leaving.departures = {scene.drop(id)};
    expect_exact(leaving);
  }
}

// All at once: two motions and the oldest frame.
TEST_P(Marginalisation, OfMotionsWithTheOldestFrame) {
  for (int i = 0; i < 2; ++i) {
    expect_exact(scene.oldest_leaves());
    scene.move();
  }
  Leaving leaving = scene.oldest_leaves();
  for (const LandmarkId id : {Scene::kMoving, Scene::kFreed}) {
    std::erase_if(leaving.departures, [&](const Departure& d) { return d.landmark == id; });
    leaving.departures.push_back(scene.drop(id));
  }
  expect_exact(leaving);
}

// A motion of which no chain has begun: it leaves with its prior alone.
TEST_P(Marginalisation, OfAMotionWithoutAChain) {
  GraphLandmark& l = graph[Scene::kPlain];
  graph.free_landmark(Scene::kPlain, MotionVector::Constant(graph.models().landmark->motion, 0.4));
  graph.linearise();
  Leaving leaving;
  leaving.departures = {scene.drop(Scene::kPlain)};
  expect_exact(leaving);
  EXPECT_FALSE(l.is_free());
  EXPECT_FALSE(l.pixels.empty());
}

// Whole landmarks, of their own or in the prior.
TEST_P(Marginalisation, OfLandmarks) {
  Leaving leaving = scene.oldest_leaves();
  std::erase_if(leaving.departures, [](const Departure& d) { return d.landmark == Scene::kBrief; });
  leaving.departures.push_back(scene.all_of(Scene::kBrief));
  leaving.departures.push_back(scene.all_of(Scene::kKnown));
  expect_exact(leaving);
  EXPECT_FALSE(graph[Scene::kBrief].is_alive);
  scene.move();
  leaving.clear();
  leaving.departures = {scene.all_of(Scene::kPlain), scene.all_of(Scene::kLone)};
  expect_exact(leaving);
  for (int i = 0; i < 3; ++i) {
    scene.move();
    leaving = scene.oldest_leaves();
    if (i == 2) {  // its chain has come to its end
      EXPECT_EQ(graph[Scene::kMoving].steps(), 1);
    }
    expect_exact(leaving);
  }
  leaving.clear();
  leaving.departures = {scene.all_of(Scene::kMoving), scene.all_of(Scene::kFreed)};
  leaving.anchors = {scene.cameras[0].position, scene.cameras[1].position};
  expect_exact(leaving);
  EXPECT_TRUE(test::active_landmarks(graph).empty());
}

// With several steps of their chains: of their own, in the prior or partly there, alone or with the
// oldest frame.
TEST_P(Marginalisation, OfLandmarksThatMove) {
  Scene early(9, {GetParam()});
  Leaving leaving;
  ASSERT_GT(early.graph[Scene::kMoving].steps(), 1);
  leaving.departures = {early.all_of(Scene::kMoving)};
  EXPECT_LT(test::change_by_marginalising(early, leaving), kRounding);
  EXPECT_FALSE(early.graph[Scene::kMoving].is_alive);

  expect_exact(scene.oldest_leaves());
  ASSERT_TRUE(holds(graph, graph[Scene::kMoving].w) && holds(graph, graph[Scene::kFreed].y));
  ASSERT_FALSE(holds(graph, graph[Scene::kFreed].w));
  scene.move();
  ASSERT_GT(graph[Scene::kFreed].steps(), 1);
  leaving.departures = {scene.all_of(Scene::kFreed)};
  expect_exact(leaving);
  scene.move();
  ASSERT_GT(graph[Scene::kMoving].steps(), 1);
  leaving = scene.oldest_leaves();
  std::erase_if(leaving.departures,
                [](const Departure& d) { return d.landmark == Scene::kMoving; });
  leaving.departures.push_back(scene.all_of(Scene::kMoving));
  expect_exact(leaving);
  EXPECT_FALSE(graph[Scene::kMoving].is_alive);
}

INSTANTIATE_TEST_SUITE_P(Models, Marginalisation, testing::ValuesIn(test::every_model()));

}  // namespace
}  // namespace slammot
