#include "smoothers/graph/linear_form.h"

namespace slammot {

Eigen::MatrixXd replace_far(const Graph& graph, LinearForm& form) {
  const FarMap& far = graph.far();
  const Eigen::Index rows = form.J.rows();
  LinearForm near;
  std::vector<VariableId> far_variables;
  std::vector<int> near_columns, far_columns;
  int column = 0;
  for (const VariableId id : form.variables) {
    const bool is_far = far.contains(id);
    const int dim = is_far ? FarMap::kDim : graph.variables().at(id).dim();
    (is_far ? far_variables : near.variables).push_back(id);
    for (int k = 0; k < dim; ++k) (is_far ? far_columns : near_columns).push_back(column++);
  }
  if (far_variables.empty()) return Eigen::MatrixXd::Zero(rows, rows);
  const std::vector<int> at = far.rows(far_variables);
  const Eigen::MatrixXd J_far = form.J(Eigen::all, far_columns);
  Eigen::MatrixXd J_prior = J_far * far.K(at, Eigen::all);
  const LinearPrior& prior = graph.prior();
  for (std::size_t i = 0; i < prior.variables.size(); ++i) {
    const Variable& v = graph.variables().at(prior.variables[i]);
    near.variables.push_back(prior.variables[i]);
    if (!v.manifold) continue;
    auto columns = J_prior.middleCols(prior.offsets[i], v.dim());
    columns = (columns * graph.transport(v, prior.x0[i])).eval();
  }
  near.J.resize(rows, static_cast<Eigen::Index>(near_columns.size()) + J_prior.cols());
  near.J << form.J(Eigen::all, near_columns), J_prior;
  form = std::move(near);
  return J_far * far.covariance(at, at) * J_far.transpose();
}

}  // namespace slammot
