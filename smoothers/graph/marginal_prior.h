// What marginalised factors say of the active variables b that they touched: a Gaussian in
// square-root form (Bierman 1977),
//
//   |R d(b) + r|^2,
//
// where d(b) = b [-] b0, or coordinates in which a change of scale is a straight line
// (scale_chart.h). b0 is where the prior was linearised. To express the prior at the current
// estimate is to multiply its columns by D = dd/db. With fixed points (first estimates, Huang,
// Mourikis and Roumeliotis 2010) Jacobians of these variables stay where they were when the prior
// first touched them, and D is the identity.
#pragma once

#include <vector>

#include "models/growing_matrix.h"
#include "smoothers/graph/scale_chart.h"

namespace slammot {

class MarginalPrior {
 public:
  using Block = PriorBlock;

  // Empty: it touches no variable.
  explicit MarginalPrior(bool fixed_points, bool keeps_scale = false)
      : fixed_points_(fixed_points),
        chart_(keeps_scale, fixed_points),
        linear_(keeps_scale, fixed_points) {}

  const std::vector<Block>& blocks() const { return blocks_; }
  int cols() const { return cols_; }
  // Null when the prior does not touch this variable.
  const Block* find(VariableId id) const;

  // d(b), `cols` numbers; `b` says which field of the variables is meant.
  using Field = SmallVector Variable::*;
  // The result is overwritten by the next call of any function here.
  const Eigen::VectorXd& difference(Field b = &Variable::value) const;

  // The coordinates at b, overwritten likewise; and those at which the last add_to() was.
  const ScaleChart& chart(Field b = &Variable::value) const;
  const ScaleChart& chart_at_origin() const;  // at b0
  const ScaleChart& linear_chart() const { return linear_; }
  bool keeps_scale() const { return chart_.keeps_scale(); }

  // R d(b) + r, overwritten by the next residual(), square() or add_to(), and its square; zero in
  // the rows of considered landmarks.
  const Eigen::VectorXd& residual(Field b = &Variable::value) const;
  double square(Field b = &Variable::value) const;

  // The Jacobian J = R D of the residual at the current estimate, and J'(R d + r).
  Eigen::MatrixXd jacobian() const;
  const Eigen::VectorXd& gradient() const;  // overwritten by the next call, and by add_to()
  // |J n|^2 and J n . (R d + r) there, n = db/d(log scale).
  Eigen::Vector2d along_scale() const;
  Eigen::Map<const Eigen::MatrixXd> R() const { return *R_; }
  const Eigen::VectorXd& r() const { return r_; }
  // For each row of R the first column that may not be zero.
  const std::vector<int>& starts() const { return starts_; }

  // Considered landmarks (Graph::consider). The prior holds what it knows of one given the core, in
  // rows of their own: U (y, w) + K core + r, where no other considered landmark has columns. No
  // other row has theirs, so that the rest of R is the prior of the core.
  struct ConsideredRows {
    Eigen::Index first = 0, count = 0;  // rows
    int y = 0, w = -1;                  // columns; -1: not in the prior
  };
  ConsideredRows own_rows(VariableId y, VariableId w) const;
  double own_square(const ConsideredRows& rows, Field b) const;
  // Their residual and Jacobian at the current estimate, with the columns of R.
  void fill_own(const ConsideredRows& rows, Eigen::Ref<Eigen::VectorXd> residual,
                Eigen::MatrixXd& jacobian) const;
  // Variable::is_considered has changed.
  void own_variables_changed() { has_gram_ = false; }

  // Columns that stand side by side in R and in the core. Of the last add_to().
  struct Run {
    int offset = 0, core = 0, dim = 0;
  };
  const std::vector<Run>& runs() const { return runs_; }

  // Adds J'J and J'(R d + r) where Variable::core says; of H its lower triangle.
  void add_to(Eigen::Ref<Eigen::MatrixXd> H, Eigen::Ref<Eigen::VectorXd> g) const;

  // Of a constrained variable, C being its columns of J: `information` += C'C, E += (C'J)' as
  // add_transposed(). Nothing when the prior does not touch it.
  void add_constrained(VariableId id, Eigen::Ref<Eigen::MatrixXd> information,
                       Eigen::Ref<Eigen::MatrixXd> E) const;

  // C_a'C_b of two constrained variables that it touches, added likewise.
  void add_cross(VariableId a, VariableId b, Eigen::Ref<Eigen::MatrixXd> information) const;

  // E += K' where Variable::core says; K has the columns of R.
  void add_transposed(const Eigen::MatrixXd& K, Eigen::Ref<Eigen::MatrixXd> E) const;

  // Replaces the prior by |R db + r|^2 about the current estimate of `variables`, whose tangent
  // coordinates in this order are the columns of R. R is upper triangular.
  void set(const std::vector<Variable*>& variables, const Eigen::Ref<const Eigen::MatrixXd>& R,
           const Eigen::Ref<const Eigen::VectorXd>& r);

  // Expresses the prior at the current estimate, to first order: b0 := b, R := R D, r := r + R d.
  // An EKF does the same with its covariance after every update.
  void relinearise();

  // Conditions the prior on b_i = 0 exactly, and forgets that variable. It must be Euclidean, one
  // of the prior's, and b0 = b where the scale is kept.
  void condition_on_zero(VariableId id);

  // Multiplies the prior by the conditional U (d(x) - K d(b)) ~ N(0, I) of more variables x,
  // all Euclidean, about their mean. They come first, and x0 := mean.
  void join(const std::vector<Variable*>& variables, const Eigen::VectorXd& mean,
            const Eigen::MatrixXd& K, const Eigen::MatrixXd& U);

 private:
  void compute_gram() const;
  void bend_gram();
  void erase_linear(int offset, int dim);
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

  // R'R, its lower triangle, computed once after set(), condition_on_zero(), join() or
  // own_variables_changed(); every step needs it.
  mutable GrowingMatrix gram_, of_core_;
  mutable bool has_gram_ = false;
  mutable std::vector<Run> runs_;
  mutable GrowingMatrix bent_;         // J'J
  mutable ScaleChart chart_, linear_;  // the first is scratch, as is what follows
  mutable Eigen::VectorXd residual_, gradient_, along_, of_scale_;
};

}  // namespace slammot
