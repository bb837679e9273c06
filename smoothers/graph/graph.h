// The factor graph of a smoother: variables, factors that are Ceres cost functions, and a prior
// that stands for the factors that have been marginalised. Every factor keeps its last
// linearisation, expressed at the current estimate; what is solved, marginalised and reported all
// comes from these same numbers.
//
// Why not ceres::Problem and ceres::Solve in the window: see docs/smoother.md. The batch uses both.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <map>
#include <memory>
#include <set>
#include <vector>

#include "smoothers/graph/prior.h"

namespace slammot {

using FactorId = int;

struct Factor {
  std::vector<VariableId> variables;
  std::vector<Variable*> at;  // the same, in the graph
  std::unique_ptr<ceres::CostFunction> cost;
  const ceres::LossFunction* loss = nullptr;
  // r and J at the current estimate, weighted by the loss. J has the columns of each variable's
  // tangent space from offset[i] on; offset.back() is their number.
  SmallVector r;
  Eigen::MatrixXd J;
  std::vector<int> offset;
  bool valid = true;  // false: it cannot be evaluated there (behind the camera); J and r are zero

  int dim(std::size_t i) const { return offset[i + 1] - offset[i]; }
  auto jacobian(std::size_t i) { return J.middleCols(offset[i], dim(i)); }
  auto jacobian(std::size_t i) const { return J.middleCols(offset[i], dim(i)); }
};

// A correction of every active variable in its tangent space, by id.
using Step = std::map<VariableId, SmallVector>;

class Graph {
 public:
  // `first_estimates`: Jacobians of variables that the prior touches stay where they were then.
  explicit Graph(bool first_estimates) : prior_{MarginalPrior(first_estimates), {}} {}

  // `manifold` (null: Euclidean) must outlive the graph; `owner` is the track whose private state
  // the variable is, or -1.
  VariableId add_variable(const Eigen::VectorXd& value, const ceres::Manifold* manifold, int owner);
  // Adds a factor of active variables and linearises it. `loss` must outlive the graph.
  FactorId add_factor(std::vector<VariableId> variables, std::unique_ptr<ceres::CostFunction> cost,
                      const ceres::LossFunction* loss = nullptr);
  void remove_factor(FactorId id) { factors_.erase(id); }

  // Removes active variables, which no factor may touch any more, and marginalises inactive ones.
  // Throws std::logic_error when the prior still touches one.
  void remove_variables(const std::set<VariableId>& ids);

  // Brings inactive variables back into the prior, at their mean. Throws Diverged when their
  // covariance is not positive definite.
  void reactivate(const std::vector<VariableId>& ids);

  // An active variable: its value and its linearisation point may be set. Factors see either with
  // the next linearise().
  Variable& variable(VariableId id) { return variables_.at(id); }

  // Of an active variable its value; of an inactive one its mean given the current estimate of the
  // active ones.
  SmallVector value(VariableId id) const;

  const std::map<VariableId, Variable>& variables() const { return variables_; }  // active ones
  const std::map<FactorId, Factor>& factors() const { return factors_; }
  const Prior& prior() const { return prior_; }
  Prior& prior() { return prior_; }

  // Linearises all factors anew at the current estimate, and returns cost({}) there.
  double linearise();

  // Half the sum of squares (with losses) at x [+] step, prior included. A factor that is not valid
  // at x does not count: if it cost something, any step that ends this would be taken, however bad.
  double cost(const Step& step);

  // x := x [+] step, prior untouched. Stored linearisations are carried along: r += J dx, and J is
  // expressed in the tangent space at the new estimate.
  void retract(const Step& step);

 private:
  // Returns the factor's square, with its loss; 0 when it is not valid.
  double linearise(Factor& factor);
  bool evaluate(Factor& factor);

  std::map<VariableId, Variable> variables_;
  std::map<FactorId, Factor> factors_;
  Prior prior_;
  VariableId next_variable_ = 0;
  FactorId next_factor_ = 0;

  // Scratch: blocks of the factor in hand, and its Jacobians as Ceres writes them.
  std::vector<const double*> values_, points_;
  std::vector<double> ambient_;
  std::vector<double*> jacobians_;
};

// Where Jacobians with respect to an active variable are taken.
inline const SmallVector& linearisation_point(const Graph& graph, VariableId id) {
  return graph.variables().at(id).point();
}

// Graph::value() of all variables, active and inactive.
std::map<VariableId, SmallVector> values(const Graph& graph);

}  // namespace slammot
