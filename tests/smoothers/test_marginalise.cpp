// Marginalisation, first estimates and the far map, on linear problems whose answer is known.
#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <random>

#include "smoothers/graph/cost_tools.h"
#include "smoothers/graph/factors.h"
#include "smoothers/solver/marginalise.h"
#include "smoothers/solver/normal_equations.h"

namespace slammot {
namespace {

// A x + B y - c, four residuals of two blocks of three.
class LinearCost final : public ceres::SizedCostFunction<4, 3, 3> {
 public:
  explicit LinearCost(std::mt19937_64& engine) {
    std::normal_distribution<double> normal;
    for (double& v : A_.reshaped()) v = normal(engine);
    for (double& v : B_.reshaped()) v = normal(engine);
    for (double& v : c_.reshaped()) v = normal(engine);
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    using Block = Eigen::Map<const Eigen::Vector3d>;
    Eigen::Map<Eigen::Vector4d>(residuals, 4) = A_ * Block(x[0]) + B_ * Block(x[1]) - c_;
    write<4, 3>(jacobians, 0, A_);
    write<4, 3>(jacobians, 1, B_);
    return true;
  }

 private:
  Eigen::Matrix<double, 4, 3> A_, B_;
  Eigen::Vector4d c_;
};

// Twelve variables, each tied to the next and to one far away; every third belongs to a landmark.
Graph linear_problem(unsigned seed) {
  std::mt19937_64 engine(seed);
  Graph graph(false);
  for (int i = 0; i < 12; ++i) {
    graph.add_variable(Eigen::Vector3d::Zero(), nullptr, i % 3 == 2 ? i : -1);
  }
  for (int i = 0; i + 1 < 12; ++i)
    graph.add_factor({i, i + 1}, std::make_unique<LinearCost>(engine));
  graph.add_factor({0, 7}, std::make_unique<LinearCost>(engine));
  graph.add_factor({3, 10}, std::make_unique<LinearCost>(engine));
  return graph;
}

TEST(Marginalise, ThenSolvingIsSolvingThenMarginalising) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Graph whole = linear_problem(seed), part = linear_problem(seed);
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
  Graph whole = linear_problem(1), part = linear_problem(1);
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

// A variable that a prior touches is linearised where it was then, and elsewhere it is not: first
// estimates (Huang, Mourikis and Roumeliotis 2010).
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

// Variables that rest in the far map while others leave, come back and are measured again.
TEST(ConditionalMap, ToRestAndToReturnChangesNothing) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Graph whole = linear_problem(seed), part = linear_problem(seed);
    marginalise(part, {0}, {}, {}, {1});
    marginalise(part, {2}, {}, {}, {5, 8});
    marginalise(part, {3});
    EXPECT_EQ(part.prior().inactive.dim(), 9);

    const std::vector<StateProjection> asked{{{1, 8, 9}, Eigen::MatrixXd::Identity(9, 9)}};
    const Eigen::MatrixXd P = NormalEquations(whole).covariances(asked).front();
    StateProjection form = asked.front();
    Eigen::MatrixXd P_part = substitute_inactive(part, form);
    const std::vector<StateProjection> forms{form};
    P_part += NormalEquations(part).covariances(forms).front();
    // The order of a replaced form is that of its rows, which has not changed.
    EXPECT_LT((P - P_part).norm(), 1e-10 * P.norm()) << "seed " << seed;

    part.retract(NormalEquations(part).step());
    whole.retract(NormalEquations(whole).step());
    EXPECT_LT((part.value(5) - whole.value(5)).norm(), 1e-10);
    part.reactivate({5, 1});
    EXPECT_EQ(part.prior().inactive.dim(), 3);
    for (Graph* graph : {&whole, &part}) {
      std::mt19937_64 engine(100 + seed);
      graph->add_factor({1, 5}, std::make_unique<LinearCost>(engine));
      graph->add_factor({5, 10}, std::make_unique<LinearCost>(engine));
    }
    part.prior().relinearise();
    marginalise(part, {4, 6});
    part.retract(NormalEquations(part).step());
    whole.retract(NormalEquations(whole).step());
    for (const VariableId id : {1, 5, 7, 8, 9, 10, 11}) {
      EXPECT_LT((part.value(id) - whole.value(id)).norm(), 1e-9) << "seed " << seed;
    }
  }
}

// x1 = F x0 + G n with an invertible Q = G G': the substitution against the factor Q^-1/2 (x1 - F
// x0).
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

// J x - r, whatever J and r are.
class BlockCost final : public ceres::CostFunction {
 public:
  BlockCost(std::vector<Eigen::MatrixXd> J, Eigen::VectorXd r)
      : J_(std::move(J)), r_(std::move(r)) {
    set_num_residuals(static_cast<int>(r_.size()));
    for (const auto& J_i : J_)
      mutable_parameter_block_sizes()->push_back(static_cast<int>(J_i.cols()));
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> out(residuals, r_.size());
    out = -r_;
    for (std::size_t i = 0; i < J_.size(); ++i) {
      out += J_[i] * Eigen::Map<const Eigen::VectorXd>(x[i], J_[i].cols());
      if (!jacobians || !jacobians[i]) continue;
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[i], J_[i].rows(), J_[i].cols()) = J_[i];
    }
    return true;
  }

 private:
  std::vector<Eigen::MatrixXd> J_;
  Eigen::VectorXd r_;
};

// A landmark with y, w and three noises, a camera, and a shared variable whose prior has a unit
// Jacobian: the equations with the landmark eliminated against the dense ones.
TEST(NormalEquations, WithALandmarkEliminatedAreTheDenseOnes) {
  std::srand(5);
  Graph graph(false);
  std::vector<VariableId> ids;
  const std::vector<int> dims{6, 3, 1, 3, 3, 6, 6, 6}, owners{-1, -1, -1, 7, 7, 7, 7, 7};
  std::vector<int> first;
  int total = 0;
  for (std::size_t i = 0; i < dims.size(); ++i) {
    ids.push_back(graph.add_variable(Eigen::VectorXd::Random(dims[i]), nullptr, owners[i]));
    first.push_back(total);
    total += dims[i];
  }
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(total, total);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(total);
  const auto add = [&](const std::vector<std::size_t>& of, int rows, bool unit) {
    std::vector<VariableId> variables;
    std::vector<Eigen::MatrixXd> J;
    Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(rows, total);
    for (const std::size_t i : of) {
      variables.push_back(ids[i]);
      J.emplace_back(Eigen::MatrixXd::Random(rows, dims[i]));
      if (unit) J.back().setIdentity();
      wide.middleCols(first[i], dims[i]) = J.back();
    }
    const FactorId id = graph.add_factor(
        variables, std::make_unique<BlockCost>(J, Eigen::VectorXd(Eigen::VectorXd::Random(rows))));
    H += wide.transpose() * wide;
    g += wide.transpose() * graph.factors().at(id).r;
  };
  add({0}, 6, false);
  add({1}, 3, false);
  add({2}, 1, true);
  add({3, 2}, 1, false);
  add({4}, 3, true);
  for (const std::size_t n : {5, 6, 7}) add({n}, 6, true);
  add({0, 1, 3}, 2, false);
  add({0, 1, 3, 4, 5}, 2, false);
  add({0, 1, 3, 4, 5, 6}, 2, false);
  add({0, 1, 3, 4, 5, 6, 7}, 2, false);
  for (const double damping : {0.0, 0.1}) {
    const NormalEquations equations(graph, damping);
    Eigen::MatrixXd damped = H;
    damped.diagonal() *= 1.0 + damping;
    const Eigen::VectorXd dx = -damped.ldlt().solve(g);
    const Step step = equations.step();
    for (std::size_t i = 0; i < ids.size(); ++i) {
      EXPECT_LT((step.at(ids[i]) - dx.segment(first[i], dims[i])).norm(), 1e-11 * dx.norm())
          << "variable " << i << ", damping " << damping;
    }
    EXPECT_NEAR(equations.predicted_decrease(step), -g.dot(dx), 1e-10 * std::abs(g.dot(dx)));
  }
  StateProjection form{{ids[0], ids[3], ids[4], ids[6], ids[7]}, Eigen::MatrixXd::Random(4, 24)};
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(4, total);
  Eigen::Index column = 0;
  for (const std::size_t i : {0, 3, 4, 6, 7}) {
    J.middleCols(first[i], dims[i]) = form.J.middleCols(column, dims[i]);
    column += dims[i];
  }
  const Eigen::MatrixXd expected = J * H.inverse() * J.transpose();
  const Eigen::MatrixXd P = NormalEquations(graph).covariances(std::vector{form}).front();
  EXPECT_LT((P - expected).norm(), 1e-10 * expected.norm());
}

}  // namespace
}  // namespace slammot
