#include "smoothers/graph/state_projection.h"

namespace slammot {

Eigen::MatrixXd substitute_inactive(const Graph& graph, StateProjection& projection) {
  const auto& [prior, map] = graph.prior();
  const Eigen::Index rows = projection.J.rows();
  StateProjection result;
  std::vector<VariableId> inactive;
  std::vector<int> active_columns, inactive_columns;
  int column = 0;
  for (const VariableId id : projection.variables) {
    const bool is_inactive = map.contains(id);
    const int dim = is_inactive ? ConditionalMap::kDim : graph.variables().at(id).dim();
    (is_inactive ? inactive : result.variables).push_back(id);
    auto& columns = is_inactive ? inactive_columns : active_columns;
    for (int k = 0; k < dim; ++k) columns.push_back(column++);
  }
  if (inactive.empty()) return Eigen::MatrixXd::Zero(rows, rows);
  const Eigen::MatrixXd J_x = projection.J(Eigen::all, inactive_columns);
  Eigen::MatrixXd J_prior = J_x * map.gain(inactive);
  prior.transport(J_prior);
  for (const MarginalPrior::Block& b : prior.blocks()) result.variables.push_back(b.variable->id);
  result.J.resize(rows, std::ssize(active_columns) + J_prior.cols());
  result.J << projection.J(Eigen::all, active_columns), J_prior;
  projection = std::move(result);
  return J_x * map.covariance(inactive) * J_x.transpose();
}

}  // namespace slammot
