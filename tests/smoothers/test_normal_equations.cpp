// Steps and marginals of the eliminated equations against the dense ones, wherever the states of a
// landmark are: its own, in the prior, or partly there.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <functional>

#include "estimation/estimator.h"
#include "smoothers/solver/normal_equations.h"
#include "tests/smoothers/fixture/posterior.h"
#include "tests/smoothers/fixture/scene.h"

namespace slammot {
namespace {

using test::Scene;

// What the prior holds.
struct Held {
  std::string name;
  std::function<std::vector<VariableId>(const Scene&)> ids;
};
std::ostream& operator<<(std::ostream& out, const Held& held) { return out << held.name; }

const std::vector<Held> kHeld{
    {"Nothing", nullptr},
    {"CamerasAndAnchors",
     [](const Scene& s) -> std::vector<VariableId> {
       return {s.cameras[0].position, s.cameras[2].orientation, s.cameras[1].rates};
     }},
    {"StaticLandmark",
     [](const Scene& s) -> std::vector<VariableId> {
       return {s.graph[Scene::kPlain].y, s.cameras[0].orientation, s.graph[Scene::kKnown].y};
     }},
    {"BaseOfAChain",
     [](const Scene& s) -> std::vector<VariableId> {
       return {s.cameras[1].position, s.graph[Scene::kMoving].y, s.graph[Scene::kMoving].w};
     }},
    {"DepthButNotMotion",
     [](const Scene& s) -> std::vector<VariableId> {
       return {s.cameras[1].orientation, s.graph[Scene::kFreed].y, s.graph.scene->scene};
     }},
    {"SomeOfAll", [](const Scene& s) -> std::vector<VariableId> {
       const Graph& g = s.graph;
       return {g[Scene::kFreed].y,       s.cameras[1].orientation, g[Scene::kPlain].y,
               s.cameras[0].position,    g[Scene::kMoving].y,      g[Scene::kMoving].w,
               s.cameras[1].rates,       g.scene->scene,           s.cameras[1].position,
               s.cameras[4].orientation, g[Scene::kBrief].y,       s.cameras[0].orientation};
     }}};

struct EliminatedEquations : testing::TestWithParam<std::tuple<test::Model, Held>> {
  EliminatedEquations() : scene(5, {std::get<0>(GetParam())}), graph(scene.graph) {
    const Held& held = std::get<1>(GetParam());
    if (held.ids) {
      scene.hold(held.ids(scene));
      scene.move(5.0);
    }
  }
  Eigen::MatrixXd joint_rows(const test::Columns& columns, LandmarkId id) const {
    return columns.joint_rows(graph, scene.newest(), id);
  }
  void expect_what_pixels_share_is_dense() {
    const test::DenseProblem dense = test::dense_problem(graph);
    const Eigen::MatrixXd P = dense.covariance();
    equations.factorise(graph, scene.newest());
    equations.prepare(graph, std::vector<LandmarkId>{Scene::kFreed, Scene::kPlain});
    equations.prepare(graph, std::vector<LandmarkId>{5, 3, 1, 0, 2, 4});
    const std::vector<LandmarkId> ids = test::active_landmarks(graph);
    const auto count = std::ssize(ids);
    Eigen::MatrixXd C(equations.core_dim(), 2 * count + 2);
    std::vector<Eigen::MatrixXd> rows;  // of each pixel
    for (Eigen::Index i = 0; i <= count; ++i) {
      const LandmarkId id = ids[static_cast<std::size_t>(i < count ? i : 0)];
      const Eigen::MatrixXd M =
          i < count ? joint_rows(dense.columns, id) : dense.columns.rows(graph, scene.newest());
      const Eigen::MatrixXd H = Eigen::MatrixXd::Random(2, M.rows());
      equations.project(id, H, C.middleCols(2 * i, 2));
      rows.push_back(H * M);
    }
    for (Eigen::Index i = 0; i <= count; ++i) {
      for (Eigen::Index j = 0; j < i; ++j) {
        const Eigen::Matrix2d shared = C.middleCols(2 * i, 2).transpose() * C.middleCols(2 * j, 2);
        const Eigen::Matrix2d expected =
            rows[static_cast<std::size_t>(i)] * P * rows[static_cast<std::size_t>(j)].transpose();
        EXPECT_LT((shared - expected).norm(), 1e-9 * expected.norm()) << i << ", " << j;
      }
    }
  }
  Scene scene;
  Graph& graph;
  NormalEquations equations;
};

TEST_P(EliminatedEquations, StepsAreTheDenseOnes) {
  const test::DenseProblem dense = test::dense_problem(graph);
  for (const double damping : {0.0, 0.1, 10.0}) {
    equations.factorise(graph, scene.newest(), damping);
    equations.solve(graph);
    const Eigen::VectorXd dx = test::steps_of(graph), expected = dense.step(damping);
    EXPECT_LT((dx - expected).norm(), 1e-9 * expected.norm()) << "damping " << damping;
  }
}

TEST_P(EliminatedEquations, MarginalsAreTheDenseOnes) {
  const test::DenseProblem dense = test::dense_problem(graph);
  const Eigen::MatrixXd P = dense.covariance();
  equations.factorise(graph, scene.newest());
  for (const GraphCamera& camera : scene.cameras) {
    const Eigen::MatrixXd M = dense.columns.rows(graph, camera);
    const Matrix12d expected = M * P * M.transpose();
    EXPECT_LT(test::difference(equations.camera_covariance(graph, camera), expected), 1e-9);
  }
  EXPECT_LT(test::difference(equations.camera_covariance(),
                             equations.camera_covariance(graph, scene.newest())),
            1e-12);
  // Announced one by one and together, in any order, they are the same.
  equations.prepare(graph, std::vector<LandmarkId>{Scene::kFreed});
  equations.prepare(graph, std::vector<LandmarkId>{5, 3, 1, 0, 2, 4});
  for (const LandmarkId id : test::active_landmarks(graph)) {
    const Eigen::MatrixXd M = joint_rows(dense.columns, id);
    EXPECT_EQ(equations.steps(id), graph[id].steps());
    EXPECT_EQ(equations.state_dim(graph, id), M.rows() - kCameraDim - 3);
    EXPECT_LT(test::difference(equations.joint(id), M * P * M.transpose()), 1e-9) << id;
  }
}

// Of two landmarks, or of one and the camera, whether they were announced together or not. And
// again of another linearisation, by the same object: nothing of the first is read then.
TEST_P(EliminatedEquations, WhatPixelsShareIsTheDenseCovariance) {
  for (int linearisation = 0; linearisation < 2; ++linearisation) {
    if (linearisation > 0) {
      test::set_steps(graph, 0.05 * Eigen::VectorXd::Random(test::Columns(graph).size()));
      graph.retract();
      graph.linearise();
    }
    expect_what_pixels_share_is_dense();
  }
}

// After the step marginals are asked for in the tangent space that it led to.
TEST_P(EliminatedEquations, MarginalsFollowTheStep) {
  const test::DenseProblem dense = test::dense_problem(graph);
  const Eigen::MatrixXd P = dense.covariance();
  equations.factorise(graph, scene.newest());
  equations.solve(graph);
  const Eigen::Vector3d turn = graph.variables[scene.newest().orientation].step;
  graph.retract();
  equations.follow_step(graph);
  equations.prepare(graph, std::vector<LandmarkId>{Scene::kPlain, Scene::kMoving});
  for (const LandmarkId id : {Scene::kPlain, Scene::kMoving}) {
    Eigen::MatrixXd M = joint_rows(dense.columns, id);
    M.middleRows<3>(kRotation) = (right_jacobian_so3(turn) * M.middleRows<3>(kRotation)).eval();
    const Eigen::MatrixXd expected = M * P * M.transpose();
    EXPECT_LT(test::difference(equations.joint(id), expected), 1e-9);
    EXPECT_LT(test::difference(equations.camera_covariance(), expected.topLeftCorner<12, 12>()),
              1e-9);
  }
}

// The step from the graph as it was carried along is that of its stored rows.
TEST_P(EliminatedEquations, OfTheStoredLinearisation) {
  test::set_steps(graph, 0.05 * Eigen::VectorXd::Random(test::Columns(graph).size()));
  graph.retract();
  const Eigen::VectorXd expected = test::stored_problem(graph).step();
  equations.factorise(graph, scene.newest());
  equations.solve(graph);
  EXPECT_LT((test::steps_of(graph) - expected).norm(), 1e-9 * expected.norm());
  EXPECT_GT((test::dense_problem(graph).step() - expected).norm(), 1e-3 * expected.norm());
}

INSTANTIATE_TEST_SUITE_P(Scenes, EliminatedEquations,
                         testing::Combine(testing::Values(test::kModel), testing::ValuesIn(kHeld)));
INSTANTIATE_TEST_SUITE_P(Models, EliminatedEquations,
                         testing::Combine(testing::ValuesIn(test::every_model()),
                                          testing::Values(kHeld.front(), kHeld.back())));

// A landmark that has just been seen: its own three rows determine it, and nothing else. Before the
// step, and after it, in the tangent spaces that it led to.
struct LandmarkAddedSince : testing::TestWithParam<std::tuple<bool, bool>> {};

TEST_P(LandmarkAddedSince, HasItsMarginal) {
  const auto [is_free, is_after_step] = GetParam();
  Scene scene(6);
  Graph& graph = scene.graph;
  NormalEquations equations;
  equations.factorise(graph, scene.newest());
  if (is_after_step) {
    equations.solve(graph);
    graph.retract();
    equations.follow_step(graph);
  }
  equations.prepare(graph, std::vector<LandmarkId>{0});
  const LandmarkId id = graph.add_landmark(scene.newest().position, {0.1, 0.2, 0.3});
  GraphLandmark& l = graph[id];
  l.birth.kind = BirthPrior::Kind::kSharedDepth;
  l.birth.spread.sigma = 0.1;
  l.birth.scene = graph.scene->scene;
  graph.add_pixel(id, scene.newest(), {0, {330.0, 250.0}}, 0);
  if (is_free) graph.free_landmark(id, MotionVector::Constant(3, 0.4));
  graph.linearise(l);
  equations.add(graph, id);
  equations.prepare(graph, std::vector<LandmarkId>{id});
  const test::DenseProblem dense = test::stored_problem(graph);
  const Eigen::MatrixXd M = dense.columns.joint_rows(graph, scene.newest(), id);
  EXPECT_LT(test::difference(equations.joint(id), M * dense.covariance() * M.transpose()), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Steps, LandmarkAddedSince,
                         testing::Combine(testing::Bool(), testing::Bool()));

TEST(NormalEquations, WhatIsNotDeterminedIsRefused) {
  Scene scene(7);
  Graph& graph = scene.graph;
  graph[Scene::kLone].birth.kind = BirthPrior::Kind::kNone;  // one pixel has no depth
  graph.linearise();
  EXPECT_THROW(NormalEquations().factorise(graph, scene.newest()), Diverged);
}

// Three pixels of a landmark of unknown velocity: its states take nearly all that they say, and
// what is left for the cameras is the small difference of large numbers unless it is never
// subtracted.
TEST(NormalEquations, StatesThatAreHardlyDeterminedTakeNoMoreThanThereIs) {
  for (const test::Model& model : test::every_model()) {
    Scene scene(5, {model});
    GraphLandmark& l = scene.graph[Scene::kMoving];
    l.pixels.resize(3);
    l.chain.resize(static_cast<std::size_t>(l.pixels.back().depth));
    l.w_prior.sigmas *= 1e6;
    scene.graph.linearise();
    NormalEquations equations;
    equations.factorise(scene.graph, scene.newest());
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(equations.core_dim(), equations.core_dim());
    Eigen::VectorXd g = Eigen::VectorXd::Zero(equations.core_dim());
    equations.block(Scene::kMoving).add_to(H, g);
    Eigen::VectorXd before = Eigen::VectorXd::Zero(equations.core_dim());
    equations.block(Scene::kMoving).add_squares(before);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(H, Eigen::EigenvaluesOnly);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-14 * before.maxCoeff()) << model;
  }
}

}  // namespace
}  // namespace slammot
