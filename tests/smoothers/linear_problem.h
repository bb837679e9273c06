// A linear graph whose solution is unique, for tests of what should change nothing.
#pragma once

#include <ceres/sized_cost_function.h>

#include <random>

#include "smoothers/graph/cost_tools.h"
#include "smoothers/graph/graph.h"

namespace slammot::test {

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
inline Graph linear_problem(unsigned seed) {
  std::mt19937_64 engine(seed);
  Graph graph(false);
  for (int i = 0; i < 12; ++i) {
    graph.add_variable(Eigen::Vector3d::Zero(), nullptr, i % 3 == 2 ? i : -1);
  }
  for (int i = 0; i + 1 < 12; ++i) {
    graph.add_factor({i, i + 1}, std::make_unique<LinearCost>(engine));
  }
  graph.add_factor({0, 7}, std::make_unique<LinearCost>(engine));
  graph.add_factor({3, 10}, std::make_unique<LinearCost>(engine));
  return graph;
}

}  // namespace slammot::test
