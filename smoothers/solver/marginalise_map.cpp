// What a marginalisation does to the conditional map.
#include <algorithm>

#include "estimation/estimator.h"
#include "smoothers/solver/marginalise.h"

namespace slammot {

// The columns of the map's K that change: those of variables that go, or move on. What becomes of
// them is T in d(changed) = T dx.
void Marginaliser::update_map(Graph& graph, const Leaving& leaving,
                              const Triangularise::Staircase& rows) {
  ConditionalMap& map = graph.prior().inactive;
  if (map.empty()) return;
  if (rows.rows_of_first < gone_) {
    throw Diverged("what leaves the window is not determined");
  }
  std::vector<int> changed;
  const auto change = [&](const Variable& v) {
    for (int k = 0; k < v.dim(); ++k) changed.push_back(v.column + k);
  };
  for (const MarginalPrior::Block& b : graph.prior().active.blocks()) {
    if (b.variable->column < gone_ && !b.variable->is_own) change(*b.variable);
  }
  for (const VariableId id : leaving.deactivated) {
    if (graph.prior().active.find(id) == nullptr) change(graph.variables[id]);
  }
  for (std::size_t k = 0; k < local_count_; ++k) {
    if (!locals_[k].substitutes() || is_own(graph, k)) continue;
    const GraphLandmark& l = graph[locals_[k].departure().landmark];
    for (const VariableId id : {l.y, l.w}) {
      const bool is_held = graph.prior().active.find(id) != nullptr;
      if (is_held && graph.variables[id].column >= gone_) change(graph.variables[id]);
    }
  }
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(std::ssize(changed), total_);
  for (std::size_t i = 0; i < changed.size(); ++i) T(static_cast<int>(i), changed[i]) = 1.0;
  for (std::size_t k = 0; k < local_count_; ++k) {
    const LocalElimination& local = locals_[k];
    if (!local.substitutes() || is_own(graph, k)) continue;
    const GraphLandmark& l = graph[local.departure().landmark];
    const int y = graph.variables[l.y].column, w = graph.variables[l.w].column;
    const auto row_of = [&](int column) {
      return std::ranges::find(changed, column) - changed.begin();
    };
    const Eigen::Index dim = local.Psi.rows();
    for (Eigen::Index i = 0; i < dim; ++i) {
      const auto at = row_of(static_cast<int>(i < 3 ? y + i : w + i - 3));
      if (at == std::ssize(changed)) continue;  // w was not in the prior
      auto row = T.row(at);
      row.segment<3>(y) = local.Psi.row(i).head<3>();
      row.segment(w, dim - 3) = local.Psi.row(i).tail(dim - 3);
      row.segment(local.noise_column, dim) = local.noise_gain.row(i);
    }
  }
  map.eliminate(changed, T, (*A_).topLeftCorner(gone_, total_), (*A_).col(total_).head(gone_));
}

}  // namespace slammot
