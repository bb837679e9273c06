// A considered landmark in a marginalisation. It takes no part in that of the core: what the prior
// keeps of it is p(o | core), o being its y and w.
//
// Its own rows, those that leave and those of the prior, are triangularised with the noises first
// and o next; what is left of them below would correct the core, and is dropped. Then the variables
// that leave the core are eliminated from the rows of o, with p(leaving | core).
//
// Exact: the core, as if the landmark had never been measured; and p(o | core) by all that has
// left. Not exact: later measurements of o are combined with that, so that they also correct what
// has left as far as o depends on it; and what two considered landmarks, or one and an inactive
// landmark, share through variables that have left is dropped: given the core they are independent.
#pragma once

#include "smoothers/solver/local_elimination.h"

namespace slammot {

class ConsideredMarginal {
 public:
  // `local`: what leaves of it, or null.
  void compute(const Graph& graph, LandmarkId id, const LocalElimination* local, int gone,
               int total);
  // Its rows in the triangle of a marginalisation in which o alone left the core.
  void take(const Graph& graph, LandmarkId id, const Eigen::Ref<const Eigen::MatrixXd>& rows);
  // `gone_rows`: of what leaves the core, over all columns, the residual last.
  void eliminate(const Eigen::Ref<const Eigen::MatrixXd>& gone_rows);

  LandmarkId id() const { return id_; }
  // The variables of o that the prior holds, y first.
  const std::vector<VariableId>& variables() const { return own_; }
  // One row for each of their numbers: over them, the core that stays, and the residual.
  Eigen::Map<const Eigen::MatrixXd> rows() const { return *result_; }
  int dim() const { return dim_; }

 private:
  void find_own(const Graph& graph, const LocalElimination* local);
  void fill_local(const Graph& graph, const LocalElimination& local);
  void fill_prior(const Graph& graph, const LocalElimination* local, Eigen::Index first);
  int own_column(VariableId id) const;  // -1: not of o
  void reduce(GrowingMatrix& A, int first, int last);

  LandmarkId id_ = 0;
  std::vector<VariableId> own_;
  int dim_ = 0, before_ = 0;  // columns of o, and of what stands before it
  int gone_ = 0, core_ = 0;   // columns of the core that leave, and all
  GrowingMatrix A_, B_, result_;
  std::vector<int> starts_;
  Triangularise triangularise_;
};

}  // namespace slammot
