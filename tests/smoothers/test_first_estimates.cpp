// Fixed points: a variable that the prior touches keeps its linearisation point, and others do not
// (Huang, Mourikis and Roumeliotis 2010).
#include <gtest/gtest.h>

#include "smoothers/solver/normal_equations.h"
#include "tests/smoothers/fixture/posterior.h"

namespace slammot {
namespace {

using test::Scene;

constexpr double kSame = 1e-8;  // [sigma]

struct FirstEstimates : testing::TestWithParam<bool> {
  FirstEstimates() : scene(12, {test::kModel, GetParam()}), graph(scene.graph) {}
  bool are_fixed() const { return GetParam(); }
  const GraphPixel& pixel(LandmarkId id, int frame) const {
    for (const GraphPixel& p : graph[id].pixels) {
      if (p.position == scene.cameras[static_cast<std::size_t>(frame)].position) return p;
    }
    throw std::logic_error("not seen there");
  }
  Scene scene;
  Graph& graph;
};

// The prior holds frame 1, the anchor and the landmark; frame 2 it does not.
TEST_P(FirstEstimates, JacobiansBesideThePriorStay) {
  scene.marginalise(scene.oldest_leaves());
  const auto points = [&](VariableId id) -> SmallVector {
    const Variable& v = graph.variables[id];
    EXPECT_EQ(v.linearisation_point.has_value(), are_fixed() && graph.prior().active.find(id));
    return v.value;
  };
  const GraphLandmark& plain = graph[Scene::kPlain];
  const SmallVector anchor = points(plain.anchor), y = points(plain.y);
  points(scene.cameras[1].rates);
  points(scene.cameras[2].position);
  graph.linearise();
  const PixelResidual held = pixel(Scene::kPlain, 1).at, base = pixel(Scene::kMoving, 1).at,
                      beside = pixel(Scene::kPlain, 2).at;
  const CameraMotionFactor motion = graph.motions.front(), later = graph.motions.back();
  scene.move();
  const auto stays = [&](const auto& before, const auto& after) {
    EXPECT_EQ((before - after).norm() == 0.0, are_fixed());
  };
  stays(pixel(Scene::kPlain, 1).at.J_pose, held.J_pose);
  stays(pixel(Scene::kPlain, 1).at.J_anchor, held.J_anchor);
  stays(pixel(Scene::kPlain, 1).at.J_y, held.J_y);
  stays(pixel(Scene::kMoving, 1).at.J_y, base.J_y);
  EXPECT_NE(pixel(Scene::kPlain, 2).at.J_y, beside.J_y);
  EXPECT_NE(graph.motions.front().J_to, motion.J_to);
  EXPECT_NE(graph.motions.back().J_from, later.J_from);
  // Residuals belong to the values, and Jacobians to the points where there are any.
  const Variable& position = graph.variables[scene.cameras[2].position];
  const Variable& orientation = graph.variables[scene.cameras[2].orientation];
  const GraphPixel& at = pixel(Scene::kPlain, 2);
  const auto residual = [&](const SmallVector& a, const SmallVector& of_y) {
    return pixel_residual(graph.models(), at.z, position.value, quaternion(orientation.value), a,
                          of_y)
        .value();
  };
  const SmallVector new_anchor = graph.variables[plain.anchor].value,
                    new_y = graph.variables[plain.y].value;
  EXPECT_EQ(at.at.r, residual(new_anchor, new_y).r);
  const PixelResidual expected = are_fixed() ? residual(anchor, y) : residual(new_anchor, new_y);
  EXPECT_EQ(at.at.J_y, expected.J_y);
  EXPECT_EQ(at.at.J_pose, expected.J_pose);
}

// What the prior touches and deactivates in one call is no exception, nor when it returns.
TEST_P(FirstEstimates, ADeactivatedVariableKeepsItsPoint) {
  const VariableId y = graph[Scene::kBrief].y;
  const SmallVector first = graph.variables[y].value;
  Leaving leaving = scene.oldest_leaves();
  leaving.deactivated = {y};
  scene.marginalise(leaving);
  scene.move(3.0);
  graph.reactivate({y});
  EXPECT_NE(graph.variables[y].value, first);
  EXPECT_EQ(graph.variables[y].linearisation_point.has_value(), are_fixed());
  EXPECT_EQ(graph.variables[y].point() == first, are_fixed());
}

TEST_P(FirstEstimates, StepsAndMarginalsAreThoseOfTheStoredRows) {
  for (int i = 0; i < 2; ++i) {
    scene.marginalise(scene.oldest_leaves());
    scene.move(3.0);
  }
  const test::DenseProblem dense = test::stored_problem(graph);
  if (are_fixed()) {
    EXPECT_GT((dense.J - test::dense_problem(graph).J).norm(), 1e-3 * dense.J.norm());
  }
  NormalEquations equations;
  equations.factorise(graph, scene.newest());
  equations.solve(graph);
  const Eigen::VectorXd dx = dense.step();
  EXPECT_LT((test::steps_of(graph) - dx).norm(), 1e-9 * dx.norm());
  graph.retract();
  equations.follow_step(graph);
  Eigen::MatrixXd M = dense.columns.rows(graph, scene.newest());
  if (!are_fixed()) {
    const Eigen::Vector3d turn = graph.variables[scene.newest().orientation].step;
    M.middleRows<3>(kRotation) = (right_jacobian_so3(turn) * M.middleRows<3>(kRotation)).eval();
  }
  EXPECT_LT(test::difference(equations.camera_covariance(), M * dense.covariance() * M.transpose()),
            1e-9);
  if (are_fixed()) {  // residuals go along, Jacobians stay
    const test::DenseProblem after = test::stored_problem(graph);
    EXPECT_EQ(after.J, dense.J);
    const Eigen::VectorXd r = dense.r + dense.J * dx;
    const Eigen::Index rows = r.size() - graph.prior().active.r().size();
    EXPECT_LT((after.r - r).head(rows).norm(), 1e-12 * dense.r.norm());
  }
}

// Static landmarks only: F^-1 of a substitution is taken at the estimate, not at fixed points.
TEST_P(FirstEstimates, MarginalisationIsExact) {
  Leaving leaving;
  leaving.departures = {scene.drop(Scene::kMoving), scene.drop(Scene::kFreed)};
  EXPECT_LT(test::change_by_marginalising(scene, leaving), kSame);
  for (int i = 0; i < 4; ++i) {
    scene.move(3.0);
    leaving = scene.oldest_leaves();
    if (i == 0) leaving.deactivated = {graph[Scene::kBrief].y};
    EXPECT_LT(test::change_by_marginalising(scene, leaving), kSame) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(OrNot, FirstEstimates, testing::Bool());

}  // namespace
}  // namespace slammot
