// The inactive part of the map: variables that no factor touches and that are known only through
// the prior's variables b. It is a Gaussian conditional on them,
//
//   x = mean + K (b [-] b0) + e,   e ~ N(0, Sigma),
//
// where b0 and the order of K's columns are those of the prior (marginal_prior.h). The window
// solves for b only, so its cost does not grow with the map, and nothing is approximated: to
// deactivate is to factor the joint Gaussian as p(b) p(x | b), to reactivate is to multiply back.
// In a filter, Guivant and Nebot (2001) call the same idea a compressed update.
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "smoothers/graph/marginal_prior.h"

namespace slammot {

class ConditionalMap {
 public:
  static constexpr int kDim = 3;  // of every variable: anchors and y alike, all Euclidean

  bool empty() const { return entries_.empty(); }
  int dim() const { return kDim * static_cast<int>(entries_.size()); }
  bool contains(VariableId id) const { return entries_.contains(id); }

  // The mean of one variable or of all, given d = b [-] b0.
  SmallVector value(VariableId id, const Eigen::VectorXd& d) const;
  std::map<VariableId, SmallVector> values(const Eigen::VectorXd& d) const;

  // The rows of K, and of Sigma with the same columns, of these variables in their order.
  Eigen::MatrixXd gain(const std::vector<VariableId>& ids) const;
  Eigen::MatrixXd covariance(const std::vector<VariableId>& ids) const;

  // Adds a variable that is a copy of column `column` of K and the two after it: mean its value
  // there, K the identity, Sigma zero. eliminate() then takes those columns out.
  void deactivate(const Variable& variable, Eigen::Index column);

  // Marginalises the first columns of K, whose variables are R_ff d_f + R_fr d_r + r_f ~ N(0, I);
  // R = (R_ff R_fr), columns of K in the same order. Some columns of K first become combinations
  // of variables: d(columns) = T d. Though these are few, T may reach many variables that are
  // marginalised (a chain of noises), so every product here is kept as thin as they are few.
  void eliminate(const std::vector<int>& columns, const Eigen::MatrixXd& T,
                 const Eigen::MatrixXd& R, const Eigen::VectorXd& r);

  // Variables that become active again, at their mean given d = b [-] b0, and their conditional
  // U (x - mean - K (b [-] b0)) ~ N(0, I), U upper triangular.
  struct Reactivated {
    std::vector<Variable> variables;
    Eigen::VectorXd mean;
    Eigen::MatrixXd K;
    Eigen::MatrixXd U;
  };
  // Takes `ids` out and conditions the others on them: they become the first columns of K. Throws
  // Diverged when their covariance is not positive definite.
  Reactivated reactivate(const std::vector<VariableId>& ids, const Eigen::VectorXd& d);

  // Marginalises variables of the map, that is, removes them.
  void forget(const std::vector<VariableId>& ids);

  // Follows the prior that is about to be relinearised at the current estimate.
  void relinearise(const MarginalPrior& prior);
  // The same, and K gets `total` columns: those of each of the prior's variables from columns[id]
  // on, all others zero.
  void relinearise(const MarginalPrior& prior, const std::map<VariableId, int>& columns, int total);

  // Conditions on b_i = 0 for a variable of the prior, and takes its columns out.
  void condition_on_zero(const MarginalPrior::Block& block);

 private:
  struct Entry {
    int row = 0;  // the first
    Variable variable;
  };

  std::vector<int> rows(const std::vector<VariableId>& ids) const;
  Eigen::MatrixXd covariance(const std::vector<int>& rows, const std::vector<int>& columns) const;
  void make_room();

  std::map<VariableId, Entry> entries_;
  std::vector<int> vacant_;  // first rows that no variable has: zero everywhere
  Eigen::VectorXd mean_;
  Eigen::MatrixXd K_;
  Eigen::MatrixXd Sigma_;  // the lower triangle
};

}  // namespace slammot
