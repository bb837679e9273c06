// What marginalised factors say of the active variables b that they touched: a Gaussian in
// square-root form (Bierman 1977),
//
//   |R (b [-] b0) + r|^2.
//
// b0 is where the prior was linearised; b [-] b0 is in the tangent spaces there. To express the
// prior at the current estimate is to multiply its columns by the transport T = d(b [-] b0)/db,
// the identity but for rotations. With first estimates (Huang, Mourikis and Roumeliotis 2010)
// Jacobians of these variables stay where they were when the prior first touched them, and T is
// the identity everywhere.
#pragma once

#include <vector>

#include "smoothers/graph/variable.h"

namespace slammot {

class MarginalPrior {
 public:
  // Variables belong to the graph that owns the prior, and stay at their address.
  struct Block {
    const Variable* variable = nullptr;
    int offset = 0;  // first column in R
    SmallVector x0;

    int dim() const { return variable->dim(); }
  };

  // Empty: it touches no variable.
  explicit MarginalPrior(bool first_estimates) : first_estimates_(first_estimates) {}

  bool first_estimates() const { return first_estimates_; }
  const std::vector<Block>& blocks() const { return blocks_; }
  int cols() const { return static_cast<int>(R_.cols()); }
  // Null when the prior does not touch this variable.
  const Block* find(VariableId id) const;

  // b [-] b0, `cols` numbers; `b` says which field of the variables is meant.
  using Field = SmallVector Variable::*;
  Eigen::VectorXd difference(Field b = &Variable::value) const;

  // |R (b [-] b0) + r|^2.
  double square(Field b = &Variable::value) const;

  // R (b [-] b0) + r and its Jacobian R T, at the current estimate.
  Eigen::VectorXd residual() const;
  Eigen::MatrixXd jacobian() const;

  // A := A T, where A has the columns of R.
  void transport(Eigen::Ref<Eigen::MatrixXd> A) const;

  // H := T'R'R T and g := T'R'(R (b [-] b0) + r), `cols` x `cols` and `cols`. Of H only the lower
  // triangle is to be used.
  void normal_equations(Eigen::Ref<Eigen::MatrixXd> H, Eigen::Ref<Eigen::VectorXd> g) const;

  // Replaces the prior by |R db + r|^2 about the current estimate of `variables`, whose tangent
  // coordinates in this order are the columns of R. R is upper triangular.
  void set(const std::vector<Variable*>& variables, Eigen::MatrixXd R, Eigen::VectorXd r);

  // Expresses the prior at the current estimate, to first order: b0 := b, R := R T, r := r + R d.
  // An EKF does the same with its covariance after every update.
  void relinearise();

  // Conditions the prior on b_i = 0 exactly, and forgets that variable. It must be Euclidean and
  // one of the prior's.
  void condition_on_zero(VariableId id);

  // Multiplies the prior by the conditional U (x - mean - K (b [-] b0)) ~ N(0, I) of more
  // variables x, all Euclidean. They come first, and x0 := mean.
  void join(const std::vector<Variable*>& variables, const Eigen::VectorXd& mean,
            const Eigen::MatrixXd& K, const Eigen::MatrixXd& U);

 private:
  // Whether T is not the identity there.
  bool turns(const Block& block) const { return block.variable->manifold && !first_estimates_; }
  void transport_both(Eigen::Ref<Eigen::MatrixXd> M) const;  // M := T'M T

  bool first_estimates_;
  std::vector<Block> blocks_;
  Eigen::MatrixXd R_;
  Eigen::VectorXd r_;
  Eigen::MatrixXd RtR_;  // R'R, kept because every step needs it
};

}  // namespace slammot
