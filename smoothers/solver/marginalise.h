// Marginalisation in square-root form: what leaves the graph becomes part of the prior, once a
// frame for all of it.
//
// The prior and all rows that leave are stacked as A dx + b at the current estimate, with the
// leaving columns first. (A b) is brought to triangular form, and the rows below the leaving ones
// are the new prior. The Hessian is never formed. What only a landmark's own rows touch has been
// eliminated before (local_elimination.h). Considered landmarks come after (considered_marginal.h).
#pragma once

#include "smoothers/solver/considered_marginal.h"

namespace slammot {

struct Leaving {
  std::optional<GraphCamera> oldest;    // with its measurements and its motion; its position stays
  std::vector<Departure> departures;    // of landmarks with rows to give, or that go
  std::vector<VariableId> anchors;      // that no landmark uses any more; in the prior, or nowhere
  std::vector<VariableId> deactivated;  // moved to the conditional map; nothing else touches them
  LandmarkId apart = -1;                // in the prior, and to be considered from then on

  void clear();
  bool empty() const { return !oldest && departures.empty() && apart < 0; }
};

class Marginaliser {
 public:
  void operator()(Graph& graph, const Leaving& leaving);

 private:
  void order_columns(Graph& graph, const Leaving& leaving);
  void take_leaving(Graph& graph, const Leaving& leaving);
  void take_new(Graph& graph, const Leaving& leaving);
  void count_rows(const Graph& graph, const Leaving& leaving);
  void sort_rows();
  void fill(const Graph& graph, const Leaving& leaving);
  void count_prior_rows(const Graph& graph);
  void fill_prior(const Graph& graph, Eigen::Index first);
  void remove(Graph& graph, const Leaving& leaving);
  void update_map(Graph& graph, const Leaving& leaving, const Triangularise::Staircase& rows);
  std::vector<int> changed_columns(const Graph& graph, const Leaving& leaving) const;
  static void move_on(const Graph& graph, const LocalElimination& local,
                      const std::vector<int>& changed, Eigen::MatrixXd& T);
  void update_landmark(Graph& graph, const LocalElimination& local, const Leaving& leaving);
  void take(Variable& variable);
  void find_going(const Graph& graph, const Leaving& leaving);
  void compute_own(const Graph& graph, const Leaving& leaving,
                   const Triangularise::Staircase& rows);
  ConsideredMarginal& next_own();
  void set_prior(Graph& graph, const Triangularise::Staircase& rows);
  bool is_considered(const Graph& graph, std::size_t local) const {
    return graph[locals_[local].departure().landmark].is_considered;
  }
  void add_rows(int start, Eigen::Index count);

  std::vector<LocalElimination> locals_;  // those in use come first
  std::size_t local_count_ = 0;
  std::vector<ConsideredMarginal> owns_;
  std::size_t own_count_ = 0;
  std::vector<Variable*> order_;  // by column; noises are not among them
  std::vector<Variable*> own_order_;
  std::vector<VariableId> going_;
  std::vector<bool> leaves_, in_prior_;  // by variable
  int gone_ = 0, total_ = 0;
  std::vector<int> starts_;                   // of each row, in the order in which they are made
  std::vector<int> sorted_starts_;            // in that of the matrix
  std::vector<Eigen::Index> row_, by_start_;  // where each goes, and which comes there
  std::vector<int> first_from_;  // of the prior's columns: where a row that begins there begins
  GrowingMatrix A_, moved_, R_;  // R_: the new prior, its residual the last column
  Triangularise triangularise_;
};

}  // namespace slammot
