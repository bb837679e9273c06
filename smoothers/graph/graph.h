// The factor graph of a smoother: variables, factors that are Ceres cost functions, and one dense
// prior in square-root form. Every factor keeps its last linearisation, expressed at the current
// estimate; what is solved, marginalised and reported all comes from these same numbers.
//
// Why not ceres::Problem and ceres::Solve in the window: see docs/smoother.md. The batch uses both.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "smoothers/graph/far_map.h"

namespace slammot {

inline constexpr int kMaxBlock = 12;  // residuals of a factor, numbers of a variable
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxBlock, 1>;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxBlock, kMaxBlock>;

using FactorId = int;

struct Variable {
  SmallVector value;
  const ceres::Manifold* manifold = nullptr;  // null: Euclidean
  int owner = -1;                    // the track whose private state it is, or -1 when shared
  std::optional<SmallVector> first;  // where Jacobians are taken, when not at the value

  // Of the step in hand: its correction, and the value or the transport that it leads to.
  SmallVector correction, candidate;
  std::optional<Eigen::Matrix3d> turn;

  int dim() const { return manifold ? manifold->TangentSize() : static_cast<int>(value.size()); }
};

struct Factor {
  std::vector<VariableId> variables;
  std::vector<Variable*> at;  // the same, in the graph
  std::unique_ptr<ceres::CostFunction> cost;
  const ceres::LossFunction* loss = nullptr;
  Eigen::MatrixXd J;        // residuals x dims of all variables, at the current estimate
  std::vector<int> offset;  // first column of each variable in J, and the number of columns
  SmallVector r;
  bool valid =
      true;  // false: it could not be evaluated there (behind the camera), J and r are zero

  int dim(std::size_t i) const { return offset[i + 1] - offset[i]; }
  auto jacobian(std::size_t i) { return J.middleCols(offset[i], dim(i)); }
  auto jacobian(std::size_t i) const { return J.middleCols(offset[i], dim(i)); }
};

// |R (x [-] x0) + r|^2 over its variables. Empty at first.
struct LinearPrior {
  std::vector<VariableId> variables;
  std::vector<int> offsets;  // first column of each variable
  std::vector<SmallVector> x0;
  Eigen::MatrixXd R;
  Eigen::VectorXd r;
  Eigen::MatrixXd RtR;  // kept, because it is needed at every step

  int cols() const { return static_cast<int>(R.cols()); }
};

// A correction of every variable, by id.
using Step = std::map<VariableId, SmallVector>;

class Graph {
 public:
  // `first_estimates`: Jacobians of variables that a prior touches stay where they were then, at
  // the first estimate or where linearise_at() has put them.
  explicit Graph(bool first_estimates) : first_estimates_(first_estimates) {}

  VariableId add_variable(const Eigen::VectorXd& value, const ceres::Manifold* manifold, int owner);
  // Adds a factor and linearises it at the current estimate.
  FactorId add_factor(std::vector<VariableId> variables, std::unique_ptr<ceres::CostFunction> cost,
                      const ceres::LossFunction* loss = nullptr);
  void remove_factor(FactorId id) { factors_.erase(id); }

  // Linearises all factors anew at the current estimate, and returns cost({}) there.
  double linearise();

  // Half the sum of squares (with losses) at x [+] step, prior included. A factor that is not valid
  // at x does not count: were its being so a cost, any step that ends it would be taken, however
  // bad.
  double cost(const Step& step);

  // x := x [+] step. Stored linearisations are carried along: r += J dx, and J is expressed at the
  // new estimate.
  void move(const Step& step);

  // w := 0 exactly: its factors must have been removed, the prior is conditioned on it.
  void fix_at_zero(VariableId id);

  // Takes out variables that no factor and no prior touches any more, or of the far map.
  void remove_variables(const std::set<VariableId>& ids);

  // Brings variables back from the far map into the prior, at what is believed of them now.
  void bring_back(const std::vector<VariableId>& ids);

  void set_value(VariableId id, const SmallVector& value) { variables_.at(id).value = value; }

  using Values = std::map<VariableId, SmallVector>;
  void forget_first_estimate(VariableId id);
  // From the next linearisation on, Jacobians with respect to this variable are taken there.
  void linearise_at(VariableId id, const Eigen::VectorXd& point) {
    variables_.at(id).first = point;
  }
  // Where they are taken.
  SmallVector point(VariableId id) const {
    const auto near = variables_.find(id);
    return near != variables_.end() && near->second.first ? *near->second.first : value(id);
  }
  Values far_values() const;  // as value() of each

  // Residual of the prior at the current estimate, and R expressed there.
  Eigen::VectorXd prior_difference() const;
  Eigen::MatrixXd prior_jacobian() const;
  // Expresses the prior at the current estimate, to first order: x0 := x, R := R T, r := r + R d.
  // What an EKF does with its covariance after every update.
  void rebase_prior();
  // x0 := the current estimate, for a prior (R, r) that is expressed there.
  void set_prior(std::vector<VariableId> variables, Eigen::MatrixXd R, Eigen::VectorXd r);

  // Takes the far map out, expressed at the current estimate as the prior is; its K gets the
  // `total` columns of `columns`, with zeros where a variable is new to the prior.
  FarMap take_far(const std::map<VariableId, int>& columns, int total);
  // Puts it back; its columns are the prior's. `rested` leave the variables of the graph.
  void set_far(FarMap far, const std::set<VariableId>& rested);

  // The numbers of a variable, for Ceres to move.
  double* data(VariableId id) { return variables_.at(id).value.data(); }

  const std::map<VariableId, Variable>& variables() const { return variables_; }
  const std::map<FactorId, Factor>& factors() const { return factors_; }
  const LinearPrior& prior() const { return prior_; }
  const FarMap& far() const { return far_; }
  // Of a variable in the far map, its mean given the current estimate of the others.
  SmallVector value(VariableId id) const;
  bool first_estimates() const { return first_estimates_; }

  // The change of the tangent coordinates of a variable from x0 to x: d(x [-] x0)/dx, the identity
  // but for rotations; the identity also with first estimates, which never move.
  SmallMatrix transport(const Variable& v, const SmallVector& x0) const;

 private:
  // Returns the factor's square, with its loss; 0 when it is not valid.
  double linearise(Factor& factor);
  double prior_square(const Eigen::VectorXd& difference) const;

  bool first_estimates_;
  std::map<VariableId, Variable> variables_;
  std::map<FactorId, Factor> factors_;
  LinearPrior prior_;
  FarMap far_;
  std::map<VariableId, Variable> resting_;  // the variables of the far map
  std::vector<double> ambient_;             // Jacobians as Ceres wants them, of the factor in hand
  std::vector<const double*> here_, there_;
  std::vector<double*> jacobians_;
  VariableId next_variable_ = 0;
  FactorId next_factor_ = 0;
};

// x [+] d and y [-] x of a variable.
SmallVector plus(const ceres::Manifold* manifold, const SmallVector& x, const SmallVector& d);
SmallVector minus(const ceres::Manifold* manifold, const SmallVector& y, const SmallVector& x);

}  // namespace slammot
