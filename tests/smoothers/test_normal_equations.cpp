// Steps, predicted decrease and covariances of the eliminated equations against the dense ones.
#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "smoothers/solver/normal_equations.h"

namespace slammot {
namespace {

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

// A camera, a landmark with y, w and three noises, and a shared variable that has a unit prior as
// the noises have.
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
  const StateProjection projection{{ids[0], ids[3], ids[4], ids[6], ids[7]},
                                   Eigen::MatrixXd::Random(4, 24)};
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(4, total);
  Eigen::Index column = 0;
  for (const std::size_t i : {0, 3, 4, 6, 7}) {
    J.middleCols(first[i], dims[i]) = projection.J.middleCols(column, dims[i]);
    column += dims[i];
  }
  const Eigen::MatrixXd expected = J * H.inverse() * J.transpose();
  const Eigen::MatrixXd P = NormalEquations(graph).covariances(std::vector{projection}).front();
  EXPECT_LT((P - expected).norm(), 1e-10 * expected.norm());
}

}  // namespace
}  // namespace slammot
