#include "smoothers/solver/marginalise.h"

#include <map>

#include "smoothers/linear/triangularise.h"

namespace slammot {

namespace {

// Where each variable stands in the stacked system.
struct Columns {
  std::vector<VariableId> order;
  std::map<VariableId, int> offset;
  int total = 0;
  int gone = 0;  // the first ones: of what leaves or is deactivated

  void take(const Graph& graph, VariableId id) {
    if (!offset.try_emplace(id, total).second) return;
    order.push_back(id);
    total += graph.variables().at(id).dim();
  }
};

std::vector<FactorId> factors_touching(const Graph& graph, const std::set<VariableId>& ids,
                                       const std::set<FactorId>& also) {
  std::vector<FactorId> touched;
  for (const auto& [id, factor] : graph.factors()) {
    bool touches = also.contains(id);
    for (const VariableId v : factor.variables) touches = touches || ids.contains(v);
    if (touches) touched.push_back(id);
  }
  return touched;
}

// Leaving, then deactivated, then advancing, then new to the prior, then the rest of the prior as
// it was. What leaves or advances stands in the first columns of the old prior, so that the other
// columns of it remain a triangle.
Columns order_columns(const Graph& graph, const std::set<VariableId>& leaving,
                      const std::set<VariableId>& deactivated, const std::vector<Advance>& advances,
                      const std::vector<FactorId>& touched) {
  Columns columns;
  std::vector<VariableId> prior;
  for (const MarginalPrior::Block& b : graph.prior().active.blocks()) {
    prior.push_back(b.variable->id);
  }
  for (const VariableId id : prior) {
    if (leaving.contains(id)) columns.take(graph, id);
  }
  for (const VariableId id : leaving) columns.take(graph, id);
  for (const VariableId id : deactivated) columns.take(graph, id);
  columns.gone = columns.total;
  for (const Advance& a : advances) {
    columns.take(graph, a.y);
    columns.take(graph, a.w);
  }
  const std::set<VariableId> old(prior.begin(), prior.end());
  for (const FactorId id : touched) {
    for (const VariableId v : graph.factors().at(id).variables) {
      if (!old.contains(v)) columns.take(graph, v);
    }
  }
  for (const VariableId id : prior) columns.take(graph, id);
  return columns;
}

// (A b) of the factors and the prior, at the current estimate.
Eigen::MatrixXd stack(const Graph& graph, const Columns& columns,
                      const std::vector<FactorId>& touched) {
  const MarginalPrior& prior = graph.prior().active;
  const Eigen::MatrixXd J = prior.jacobian();
  Eigen::Index rows = J.rows();
  for (const FactorId id : touched) rows += graph.factors().at(id).r.size();
  Eigen::MatrixXd Ab = Eigen::MatrixXd::Zero(rows, columns.total + 1);
  Eigen::Index row = 0;
  for (const FactorId id : touched) {
    const Factor& factor = graph.factors().at(id);
    for (std::size_t i = 0; i < factor.variables.size(); ++i) {
      const int column = columns.offset.at(factor.variables[i]);
      Ab.block(row, column, factor.r.size(), factor.dim(i)) = factor.jacobian(i);
    }
    Ab.col(columns.total).segment(row, factor.r.size()) = factor.r;
    row += factor.r.size();
  }
  for (const MarginalPrior::Block& b : prior.blocks()) {
    Ab.block(row, columns.offset.at(b.variable->id), J.rows(), b.dim()) =
        J.middleCols(b.offset, b.dim());
  }
  if (prior.cols() > 0) Ab.col(columns.total).tail(J.rows()) = prior.residual();
  return Ab;
}

// dx = F^-1 (dx1 - G dnoise) in the columns of A.
void substitute(Eigen::MatrixXd& Ab, const Columns& columns, const Advance& advance) {
  const Eigen::Index dim = advance.next.size(), motion = dim - 3;
  Eigen::MatrixXd A_x(Ab.rows(), dim);
  auto A_y = Ab.middleCols<3>(columns.offset.at(advance.y));
  auto A_w = Ab.middleCols(columns.offset.at(advance.w), motion);
  A_x << A_y, A_w;
  const Eigen::MatrixXd A_next = A_x * advance.F_inverse;
  A_y = A_next.leftCols<3>();
  A_w = A_next.rightCols(motion);
  Ab.middleCols(columns.offset.at(advance.noise), dim).noalias() -= A_next * advance.G;
}

// Makes the substitutions, in A and in the values: y and w are the next state from now on.
void advance(Graph& graph, Eigen::MatrixXd& Ab, const Columns& columns,
             const std::vector<Advance>& advances) {
  for (const Advance& a : advances) {
    substitute(Ab, columns, a);
    for (const VariableId id : {a.y, a.w}) graph.variable(id).linearisation_point.reset();
    graph.variable(a.y).value = a.next.head<3>();
    graph.variable(a.w).value = a.next.tail(a.next.size() - 3);
  }
}

// The columns of the map's K that this marginalisation changes: those of variables that were in the
// prior and go, or are deactivated now, or advance.
std::vector<int> changed_columns(const Graph& graph, const Columns& columns,
                                 const std::vector<Advance>& advances,
                                 const std::set<VariableId>& deactivated) {
  std::set<VariableId> ids(deactivated);
  for (const MarginalPrior::Block& b : graph.prior().active.blocks()) {
    if (columns.offset.at(b.variable->id) < columns.gone) ids.insert(b.variable->id);
  }
  for (const Advance& a : advances) ids.insert({a.y, a.w});
  std::vector<int> changed;
  for (const VariableId id : ids) {
    for (int k = 0; k < graph.variables().at(id).dim(); ++k) {
      changed.push_back(columns.offset.at(id) + k);
    }
  }
  return changed;
}

// What has become of these columns: T in d(changed) = T dx, by the substitutions.
Eigen::MatrixXd substituted(const std::vector<int>& changed, const Columns& columns,
                            const std::vector<Advance>& advances) {
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(std::ssize(changed), columns.total);
  for (std::size_t i = 0; i < changed.size(); ++i) T(static_cast<int>(i), changed[i]) = 1.0;
  for (const Advance& a : advances) substitute(T, columns, a);
  return T;
}

}  // namespace

void marginalise(Graph& graph, const std::set<VariableId>& leaving,
                 const std::vector<Advance>& advances, const std::set<FactorId>& absorbed,
                 const std::set<VariableId>& deactivated) {
  if (leaving.empty() && deactivated.empty()) return;
  std::set<VariableId> concerned = leaving;
  concerned.insert(deactivated.begin(), deactivated.end());
  for (const Advance& a : advances) concerned.insert({a.y, a.w});
  const std::vector<FactorId> touched = factors_touching(graph, concerned, absorbed);
  const Columns columns = order_columns(graph, leaving, deactivated, advances, touched);
  auto& [prior, map] = graph.prior();

  Eigen::MatrixXd Ab = stack(graph, columns, touched);
  map.relinearise(prior, columns.offset, columns.total);
  for (const VariableId id : deactivated) {
    map.deactivate(graph.variable(id), columns.offset.at(id));
  }
  advance(graph, Ab, columns, advances);
  const Eigen::MatrixXd R = triangularise(Ab);

  const int gone = columns.gone, kept = columns.total - gone;
  if (!map.empty()) {
    const std::vector<int> changed = changed_columns(graph, columns, advances, deactivated);
    map.eliminate(changed, substituted(changed, columns, advances),
                  R.topLeftCorner(gone, columns.total), R.col(columns.total).head(gone));
  }
  std::vector<Variable*> remaining;
  for (const VariableId id : columns.order) {
    if (columns.offset.at(id) >= gone) remaining.push_back(&graph.variable(id));
  }
  prior.set(remaining, R.block(gone, gone, kept, kept), R.col(columns.total).segment(gone, kept));
  for (const FactorId id : touched) graph.remove_factor(id);
  graph.remove_variables(leaving);
  graph.remove_variables(deactivated);
}

}  // namespace slammot
