#include "smoothers/solver/marginalise.h"

#include "smoothers/solver/triangularise.h"

namespace slammot {

namespace {

struct Columns {
  std::vector<VariableId> order;
  std::map<VariableId, int> offset;
  int total = 0;

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

// Leaving, then resting, then advancing, then new to the prior, then the rest of the prior as it
// was. So the old prior stays a triangle but for its first columns, because what leaves or advances
// stands there.
Columns order_columns(const Graph& graph, const std::set<VariableId>& leaving,
                      const std::set<VariableId>& resting, const std::vector<Advance>& advances,
                      const std::vector<FactorId>& touched) {
  Columns columns;
  const std::vector<VariableId>& prior = graph.prior().variables;
  for (const VariableId id : prior) {
    if (leaving.contains(id)) columns.take(graph, id);
  }
  for (const VariableId id : leaving) columns.take(graph, id);
  for (const VariableId id : resting) columns.take(graph, id);
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
  const LinearPrior& prior = graph.prior();
  Eigen::Index rows = prior.R.rows();
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
  if (prior.cols() == 0) return Ab;
  const Eigen::MatrixXd J = graph.prior_jacobian();
  for (std::size_t i = 0; i < prior.variables.size(); ++i) {
    const int dim = graph.variables().at(prior.variables[i]).dim();
    Ab.block(row, columns.offset.at(prior.variables[i]), J.rows(), dim) =
        J.middleCols(prior.offsets[i], dim);
  }
  Ab.col(columns.total).tail(prior.R.rows()) = prior.R * graph.prior_difference() + prior.r;
  return Ab;
}

void substitute(Eigen::MatrixXd& Ab, const Columns& columns, const Advance& advance) {
  Eigen::MatrixXd A_x(Ab.rows(), 6);
  auto A_y = Ab.middleCols<3>(columns.offset.at(advance.y));
  auto A_w = Ab.middleCols<3>(columns.offset.at(advance.w));
  A_x << A_y, A_w;
  const Eigen::MatrixXd A_next = A_x * advance.F_inverse;
  A_y = A_next.leftCols<3>();
  A_w = A_next.rightCols<3>();
  Ab.middleCols<6>(columns.offset.at(advance.noise)).noalias() -= A_next * advance.G;
}

// The columns of the far map's K that this marginalisation changes: of what goes and was in the
// prior, or rests now, and of what advances.
std::vector<int> far_columns(const Graph& graph, const Columns& columns, int gone,
                             const std::vector<Advance>& advances,
                             const std::set<VariableId>& resting) {
  std::set<VariableId> ids(resting);
  for (const VariableId id : graph.prior().variables) {
    if (columns.offset.at(id) < gone) ids.insert(id);
  }
  for (const Advance& a : advances) ids.insert({a.y, a.w});
  std::vector<int> stands;
  for (const VariableId id : ids) {
    for (int k = 0; k < graph.variables().at(id).dim(); ++k) {
      stands.push_back(columns.offset.at(id) + k);
    }
  }
  return stands;
}

}  // namespace

void marginalise(Graph& graph, const std::set<VariableId>& leaving,
                 const std::vector<Advance>& advances, const std::set<FactorId>& absorbed,
                 const std::set<VariableId>& resting) {
  if (leaving.empty() && resting.empty()) return;
  std::set<VariableId> concerned = leaving;
  concerned.insert(resting.begin(), resting.end());
  for (const Advance& a : advances) concerned.insert({a.y, a.w});
  const std::vector<FactorId> touched = factors_touching(graph, concerned, absorbed);
  const Columns columns = order_columns(graph, leaving, resting, advances, touched);
  Eigen::MatrixXd Ab = stack(graph, columns, touched);
  FarMap far = graph.take_far(columns.offset, columns.total);
  for (const VariableId id : resting) far.add(id, graph.value(id), columns.offset.at(id));
  for (const Advance& a : advances) {
    substitute(Ab, columns, a);
    graph.set_value(a.y, a.next.head<3>());
    graph.set_value(a.w, a.next.tail<3>());
    graph.forget_first_estimate(a.y);  // it is another state now
    graph.forget_first_estimate(a.w);
  }
  const Eigen::MatrixXd R = triangularise(Ab);
  int gone = 0;  // numbers that leave or rest
  std::vector<VariableId> remaining;
  for (const VariableId id : columns.order) {
    if (leaving.contains(id) || resting.contains(id)) {
      gone += graph.variables().at(id).dim();
    } else {
      remaining.push_back(id);
    }
  }
  if (!far.empty()) {
    const std::vector<int> stands = far_columns(graph, columns, gone, advances, resting);
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(std::ssize(stands), columns.total);
    for (std::size_t i = 0; i < stands.size(); ++i) T(static_cast<int>(i), stands[i]) = 1.0;
    for (const Advance& a : advances) substitute(T, columns, a);
    far.eliminate(stands, T, R.topLeftCorner(gone, columns.total), R.col(columns.total).head(gone));
  }
  for (const FactorId id : touched) graph.remove_factor(id);
  const int kept = columns.total - gone;
  graph.set_prior(std::move(remaining), R.block(gone, gone, kept, kept),
                  R.col(columns.total).segment(gone, kept));
  graph.set_far(std::move(far), resting);
  graph.remove_variables(leaving);
}

}  // namespace slammot
