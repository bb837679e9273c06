// What marginalised factors say of the active variables b that they touched: a Gaussian in
// square-root form (Bierman 1977),
//
//   |R (b [-] b0) + r|^2.
//
// b0 is where the prior was linearised; b [-] b0 is in the tangent spaces there. To express the
// prior at the current estimate is to multiply its columns by the transport T = d(b [-] b0)/db,
// the identity but for orientations. With fixed points (first estimates, Huang, Mourikis and
// Roumeliotis 2010) Jacobians of these variables stay where they were when the prior first touched
// them, and T is the identity everywhere.
#pragma once

#include <vector>

#include "models/growing_matrix.h"
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
  explicit MarginalPrior(bool fixed_points) : fixed_points_(fixed_points) {}

  const std::vector<Block>& blocks() const { return blocks_; }
  int cols() const { return cols_; }
  // Null when the prior does not touch this variable.
  const Block* find(VariableId id) const;

  // b [-] b0, `cols` numbers; `b` says which field of the variables is meant.
  using Field = SmallVector Variable::*;
  // The result is overwritten by the next call of any function here.
  const Eigen::VectorXd& difference(Field b = &Variable::value) const;

  // R (b [-] b0) + r, overwritten by the next residual(), square() or add_to(), and its square;
  // zero in the rows of considered landmarks.
  const Eigen::VectorXd& residual(Field b = &Variable::value) const;
  double square(Field b = &Variable::value) const;

  // The Jacobian R T of the residual at the current estimate.
  Eigen::MatrixXd jacobian() const;
  Eigen::Map<const Eigen::MatrixXd> R() const { return *R_; }
  const Eigen::VectorXd& r() const { return r_; }
  // For each row of R the first column that may not be zero.
  const std::vector<int>& starts() const { return starts_; }

  // A := A T, where A has the columns of R.
  void transport(Eigen::Ref<Eigen::MatrixXd> A) const;

  // Considered landmarks (Graph::consider). The prior holds what it knows of one given the core, in
  // rows of their own: U (y, w) + K core + r, where no other considered landmark has columns. No
  // other row has theirs, so that the rest of R is the prior of the core.
  struct OwnRows {
    Eigen::Index first = 0, count = 0;  // rows
    int y = 0, w = -1;                  // columns; -1: not in the prior
  };
  OwnRows own_rows(VariableId y, VariableId w) const;
  double own_square(const OwnRows& rows, Field b) const;
  // Their residual, and K T over columns of the core that stand side by side, one `run` after the
  // other as in runs().
  void fill_own(const OwnRows& rows, Eigen::Ref<Eigen::VectorXd> residual,
                Eigen::Ref<Eigen::MatrixXd> K) const;
  // Variable::is_own has changed.
  void own_variables_changed() { has_gram_ = false; }

  // Columns that stand side by side in R and in the core, and do not turn; or one orientation. Of
  // the last add_to().
  struct Run {
    int offset = 0, core = 0, dim = 0;
    bool turning = false;
    Eigen::Matrix3d T;
  };
  const std::vector<Run>& runs() const { return runs_; }

  // Adds T'R'R T and T'R'(R (b [-] b0) + r) where Variable::core says; of H its lower triangle.
  void add_to(Eigen::Ref<Eigen::MatrixXd> H, Eigen::Ref<Eigen::VectorXd> g) const;

  // Of a constrained variable, C being its columns of R: `information` += C'C, E += (C'R T)' as
  // add_transposed(), `gradient` += C'residual. Nothing when the prior does not touch it.
  void add_constrained(VariableId id, const Eigen::VectorXd& residual,
                       Eigen::Ref<Eigen::MatrixXd> information, Eigen::Ref<Eigen::MatrixXd> E,
                       Eigen::Ref<Eigen::VectorXd> gradient) const;

  // E += (K T)' where Variable::core says; K has the columns of R. T is that of the last add_to().
  void add_transposed(const Eigen::MatrixXd& K, Eigen::Ref<Eigen::MatrixXd> E) const;

  // Replaces the prior by |R db + r|^2 about the current estimate of `variables`, whose tangent
  // coordinates in this order are the columns of R. R is upper triangular.
  void set(const std::vector<Variable*>& variables, const Eigen::Ref<const Eigen::MatrixXd>& R,
           const Eigen::Ref<const Eigen::VectorXd>& r);

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
  bool turns(const Block& block) const { return block.variable->is_orientation && !fixed_points_; }
  void compute_gram() const;
  void find_runs() const;
  Eigen::Index row_of(int column) const;  // the first that begins there or later
  template <typename Function>
  void for_own_rows(Function&& function) const;

  bool fixed_points_;
  int cols_ = 0;
  std::vector<Block> blocks_;
  GrowingMatrix R_;
  Eigen::VectorXd r_;
  std::vector<int> starts_;

  // R'R, computed once after R has changed; every step needs it.
  mutable GrowingMatrix gram_, of_core_;
  mutable bool has_gram_ = false;
  mutable std::vector<Run> runs_;
  mutable GrowingMatrix turned_;                              // scratch
  mutable Eigen::VectorXd difference_, residual_, gradient_;  // scratch
};

}  // namespace slammot
