// What a marginalisation does to the conditional map.
#include <algorithm>

#include "estimation/estimator.h"
#include "smoothers/solver/marginalise.h"

namespace slammot {

// What becomes of the columns of the map's K that change is T in d(changed) = T dx.
void Marginaliser::update_map(Graph& graph, const Leaving& leaving,
                              const Triangularise::Staircase& rows) {
  ConditionalMap& map = graph.prior().inactive;
  if (map.empty()) return;
  if (rows.rows_of_first < gone_) {
    throw Diverged("what leaves the window is not determined");
  }
  const std::vector<int> changed = changed_columns(graph, leaving);
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(std::ssize(changed), total_);
  for (std::size_t i = 0; i < changed.size(); ++i) T(static_cast<int>(i), changed[i]) = 1.0;
  for (std::size_t k = 0; k < local_count_; ++k) {
    if (locals_[k].substitutes() && !is_considered(graph, k))
      move_on(graph, locals_[k], changed, T);
  }
  map.eliminate(changed, T, (*A_).topLeftCorner(gone_, total_), (*A_).col(total_).head(gone_));
}

// Those of variables that go, or move on.
std::vector<int> Marginaliser::changed_columns(const Graph& graph, const Leaving& leaving) const {
  const MarginalPrior& prior = graph.prior().active;
  std::vector<int> changed;
  const auto change = [&](const Variable& v) {
    for (int k = 0; k < v.dim(); ++k) changed.push_back(v.column + k);
  };
  for (const MarginalPrior::Block& b : prior.blocks()) {
    if (b.variable->column < gone_ && !b.variable->is_considered) change(*b.variable);
  }
  for (const VariableId id : leaving.deactivated) {
    if (prior.find(id) == nullptr) change(graph.variables[id]);
  }
  for (std::size_t k = 0; k < local_count_; ++k) {
    if (!locals_[k].substitutes() || is_considered(graph, k)) continue;
    const GraphLandmark& l = graph[locals_[k].departure().landmark];
    for (const VariableId id : {l.y, l.w}) {
      const bool is_in_prior = prior.find(id) != nullptr;
      if (is_in_prior && graph.variables[id].column >= gone_) change(graph.variables[id]);
    }
  }
  return changed;
}

// dx_0 = Psi dx_d + noise_gain dn of a landmark that moves on along its chain.
void Marginaliser::move_on(const Graph& graph, const LocalElimination& local,
                           const std::vector<int>& changed, Eigen::MatrixXd& T) {
  const GraphLandmark& l = graph[local.departure().landmark];
  const int y = graph.variables[l.y].column, w = graph.variables[l.w].column;
  const Eigen::Index dim = local.Psi.rows();
  for (Eigen::Index i = 0; i < dim; ++i) {
    const int column = static_cast<int>(i < 3 ? y + i : w + i - 3);
    const auto at = std::ranges::find(changed, column) - changed.begin();
    if (at == std::ssize(changed)) continue;  // w was not in the prior
    auto row = T.row(at);
    row.segment<3>(y) = local.Psi.row(i).head<3>();
    row.segment(w, dim - 3) = local.Psi.row(i).tail(dim - 3);
    row.segment(local.noise_column, dim) = local.noise_gain.row(i);
  }
}

}  // namespace slammot
