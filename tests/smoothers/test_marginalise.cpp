// Marginalisation and first estimates, on linear problems whose answer is known.
#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <random>

#include "smoothers/graph/factors.h"
#include "smoothers/solver/marginalise.h"
#include "smoothers/solver/normal_equations.h"
#include "tests/smoothers/linear_problem.h"

namespace slammot {
namespace {

TEST(Marginalise, ThenSolvingIsSolvingThenMarginalising) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Graph whole = test::linear_problem(seed), part = test::linear_problem(seed);
    const Step solution = NormalEquations(whole).step();
    const std::vector<std::vector<VariableId>> kept{{4, 6, 7}, {9, 10, 11}};
    const auto P = NormalEquations(whole).covariances(kept);
    marginalise(part, {0, 1});
    marginalise(part, {2});
    marginalise(part, {3, 5, 8});
    const NormalEquations equations(part);
    const Step step = equations.step();
    const auto P_part = equations.covariances(kept);
    for (const VariableId id : {4, 6, 7, 9, 10, 11}) {
      EXPECT_LT((step.at(id) - solution.at(id)).norm(), 1e-10 * (1.0 + solution.at(id).norm()));
    }
    for (std::size_t i = 0; i < P.size(); ++i) {
      EXPECT_LT((P[i] - P_part[i]).norm(), 1e-10 * P[i].norm()) << "seed " << seed;
    }
  }
}

TEST(Marginalise, WithoutThePriorTheAnswerIsAnother) {
  Graph whole = test::linear_problem(1), part = test::linear_problem(1);
  const Step solution = NormalEquations(whole).step();
  marginalise(part, {0, 1});
  part.prior().active.set({}, {}, {});
  const Step step = NormalEquations(part).step();
  EXPECT_GT((step.at(2) - solution.at(2)).norm(), 1e-3);
}

// x^2 - y, which has another Jacobian wherever it is evaluated.
class SquareCost final : public ceres::SizedCostFunction<1, 1, 1> {
 public:
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    residuals[0] = x[0][0] * x[0][0] - x[1][0];
    if (jacobians && jacobians[0]) jacobians[0][0] = 2.0 * x[0][0];
    if (jacobians && jacobians[1]) jacobians[1][0] = -1.0;
    return true;
  }
};

// With first estimates, a variable that the prior touches keeps its linearisation point, and others
// do not (Huang, Mourikis and Roumeliotis 2010).
TEST(FirstEstimates, JacobiansBesideThePriorStay) {
  for (const bool first_estimates : {false, true}) {
    Graph graph(first_estimates);
    const Eigen::VectorXd three = Eigen::VectorXd::Constant(1, 3.0);
    const VariableId old = graph.add_variable(three, nullptr, -1);
    const VariableId x = graph.add_variable(three, nullptr, -1);
    const VariableId y = graph.add_variable(three, nullptr, -1);
    graph.add_factor({old, x}, std::make_unique<SquareCost>());
    graph.add_factor({x, old}, std::make_unique<SquareCost>());
    marginalise(graph, {old});
    const FactorId beside = graph.add_factor({x, y}, std::make_unique<SquareCost>());
    const FactorId apart = graph.add_factor({y, x}, std::make_unique<SquareCost>());
    Step step;
    step[x] = step[y] = SmallVector::Constant(1, 2.0);
    graph.retract(step);
    graph.linearise();
    EXPECT_DOUBLE_EQ(graph.factors().at(beside).J(0, 0), first_estimates ? 6.0 : 10.0);
    EXPECT_DOUBLE_EQ(graph.factors().at(beside).r(0), 20.0);
    EXPECT_DOUBLE_EQ(graph.factors().at(apart).J(0, 0), 10.0);
  }
}

// x1 = F x0 + G n: after the substitution x1 has the covariance F P0 F' + G G'.
TEST(Marginalise, AdvanceIsTheTimeUpdate) {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  Matrix6d F = Matrix6d::Identity(), G = Matrix6d::Zero(), P0 = Matrix6d::Zero();
  for (int i = 0; i < 36; ++i) {
    F.data()[i] += 0.2 * normal(engine);
    G.data()[i] = normal(engine);
    P0.data()[i] = normal(engine);
  }
  P0 = P0 * P0.transpose() + Matrix6d::Identity();
  Graph graph(false);
  const VariableId y = graph.add_variable(Eigen::Vector3d::Zero(), nullptr, 1);
  const VariableId w = graph.add_variable(Eigen::Vector3d::Zero(), nullptr, 1);
  const Matrix6d root = P0.inverse().llt().matrixU();
  graph.prior().active.set({&graph.variable(y), &graph.variable(w)}, root, Vector6d::Zero());
  const VariableId n = graph.add_variable(Vector6d::Zero(), nullptr, 1);
  graph.add_factor({n}, noise_prior_cost());
  const Vector6d next = Vector6d::Constant(0.5);
  marginalise(graph, {n}, {{y, w, n, F.inverse(), G, next}});
  const std::vector<std::vector<VariableId>> both{{y, w}};
  const Matrix6d P = NormalEquations(graph).covariances(both).front();
  const Matrix6d expected = F * P0 * F.transpose() + G * G.transpose();
  EXPECT_LT((P - expected).norm(), 1e-12 * expected.norm());
  EXPECT_EQ(graph.value(y), SmallVector(next.head<3>()));
}

}  // namespace
}  // namespace slammot
