#include "slammot/smoothers/normal_equations.h"

#include <algorithm>

#include "slammot/models/estimator.h"

namespace slammot {

NormalEquations::NormalEquations(const Graph& graph, double damping) {
  place_variables(graph);
  add_prior(graph);
  add_factors(graph);
  U_.diagonal() *= 1.0 + damping;
  eliminate_groups(damping);
  core_.compute(U_);
  if (core_.info() != Eigen::Success) {
    throw Diverged("the information matrix of the window is not positive definite");
  }
}

void NormalEquations::place_variables(const Graph& graph) {
  std::map<int, int> group_of;  // by owner
  for (const VariableId id : graph.prior().variables) {
    const int dim = graph.variables().at(id).dim();
    places_[id] = {-1, core_dim_, dim};
    core_dim_ += dim;
  }
  for (const auto& [id, v] : graph.variables()) {
    if (places_.contains(id)) continue;
    if (v.owner < 0) {
      places_[id] = {-1, core_dim_, v.dim()};
      core_dim_ += v.dim();
      continue;
    }
    const auto [it, is_new] = group_of.try_emplace(v.owner, static_cast<int>(groups_.size()));
    if (is_new) groups_.emplace_back();
    Group& group = groups_[static_cast<std::size_t>(it->second)];
    places_[id] = {it->second, group.dim, v.dim()};
    group.variables.push_back(id);
    group.dim += v.dim();
  }
  U_.setZero(core_dim_, core_dim_);
  g_.setZero(core_dim_);
}

// With T = d(x [-] x0)/dx: H += T' R'R T, g += T' (R'R d + R'r).
void NormalEquations::add_prior(const Graph& graph) {
  const LinearPrior& prior = graph.prior();
  const int n = prior.cols();
  if (n == 0) return;
  U_.topLeftCorner(n, n) = prior.RtR;
  g_.head(n) = prior.RtR * graph.prior_difference() + prior.R.transpose() * prior.r;
  if (graph.first_estimates()) return;
  for (std::size_t i = 0; i < prior.variables.size(); ++i) {
    const Variable& v = graph.variables().at(prior.variables[i]);
    if (!v.manifold) continue;
    const SmallMatrix T = graph.transport(v, prior.x0[i]);
    const int at = prior.offsets[i];
    U_.block(0, at, n, v.dim()) = (U_.block(0, at, n, v.dim()) * T).eval();
    U_.block(at, 0, v.dim(), n) = (T.transpose() * U_.block(at, 0, v.dim(), n)).eval();
    g_.segment(at, v.dim()) = (T.transpose() * g_.segment(at, v.dim())).eval();
  }
}

void NormalEquations::add_factors(const Graph& graph) {
  // First which core columns each group is tied to, then the sums.
  std::vector<std::vector<const Place*>> places;         // by factor and variable
  std::vector<std::map<int, int>> ties(groups_.size());  // by offset in the core: columns
  places.reserve(graph.factors().size());
  for (const auto& [id, factor] : graph.factors()) {
    auto& of_factor = places.emplace_back();
    int group = -1;
    for (const VariableId v : factor.variables) {
      of_factor.push_back(&places_.at(v));
      group = std::max(group, of_factor.back()->group);
    }
    if (group < 0) continue;
    for (const Place* p : of_factor) {
      if (p->group < 0) ties[static_cast<std::size_t>(group)][p->offset] = p->dim;
    }
  }
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    Group& group = groups_[k];
    for (auto& [offset, column] : ties[k]) {
      const int dim = column;
      column = static_cast<int>(group.core_columns.size());
      for (int i = 0; i < dim; ++i) group.core_columns.push_back(offset + i);
    }
    group.V.setZero(group.dim, group.dim);
    group.W.setZero(group.dim, static_cast<Eigen::Index>(group.core_columns.size()));
    group.g.setZero(group.dim);
  }
  auto of_factor = places.begin();
  for (const auto& [id, factor] : graph.factors()) add_factor(factor, *of_factor++, ties);
}

// The columns of a factor that belong to a group stand together, from the first to the last that it
// touches, as J_group; then H gets J_group'J_group, J_group'J_core and J_core'J_core.
void NormalEquations::add_factor(const Factor& factor, const std::vector<const Place*>& places,
                                 const std::vector<std::map<int, int>>& ties) {
  int group_index = -1, first = 0, end = 0;
  for (const Place* p : places) {
    if (p->group < 0) continue;
    first = group_index < 0 ? p->offset : std::min(first, p->offset);
    end = std::max(end, p->offset + p->dim);
    group_index = p->group;
  }
  J_group_.setZero(factor.r.size(), end - first);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& p = *places[i];
    if (p.group >= 0) J_group_.middleCols(p.offset - first, p.dim) = factor.J[i];
  }
  if (group_index >= 0) {
    Group& group = groups_[static_cast<std::size_t>(group_index)];
    group.V.block(first, first, end - first, end - first) +=
        J_group_.transpose().lazyProduct(J_group_);
    group.g.segment(first, end - first) += J_group_.transpose().lazyProduct(factor.r);
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& a = *places[i];
    if (a.group >= 0) continue;
    g_.segment(a.offset, a.dim) += factor.J[i].transpose().lazyProduct(factor.r);
    if (group_index >= 0) {
      const auto k = static_cast<std::size_t>(group_index);
      groups_[k].W.block(first, ties[k].at(a.offset), end - first, a.dim) +=
          J_group_.transpose().lazyProduct(factor.J[i]);
    }
    for (std::size_t j = 0; j < places.size(); ++j) {
      const Place& b = *places[j];
      if (b.group >= 0 || b.offset > a.offset) continue;  // U's lower triangle
      U_.block(a.offset, b.offset, a.dim, b.dim) +=
          factor.J[i].transpose().lazyProduct(factor.J[j]);
    }
  }
}

void NormalEquations::eliminate_groups(double damping) {
  reduced_g_ = g_;
  Eigen::MatrixXd WVW;
  for (Group& group : groups_) {
    group.V.diagonal() *= 1.0 + damping;
    group.llt.compute(group.V);
    if (group.llt.info() != Eigen::Success) {
      throw Diverged("the states of a landmark in the window are not determined");
    }
    group.LW = group.llt.matrixL().solve(group.W);
    const Eigen::VectorXd Lg = group.llt.matrixL().solve(group.g);
    const std::vector<int>& columns = group.core_columns;  // ascending
    const auto n = static_cast<Eigen::Index>(columns.size());
    if (n == 0) continue;  // tied to nothing yet; BLAS refuses matrices without columns
    WVW.setZero(n, n);
    WVW.selfadjointView<Eigen::Lower>().rankUpdate(group.LW.transpose());
    reduced_g_(columns) -= group.LW.transpose() * Lg;
    for (Eigen::Index j = 0; j < n; ++j) {
      double* column = &U_(0, columns[static_cast<std::size_t>(j)]);
      for (Eigen::Index i = j; i < n; ++i)
        column[columns[static_cast<std::size_t>(i)]] -= WVW(i, j);
    }
  }
}

Step NormalEquations::step() const {
  const Eigen::VectorXd core = -core_.solve(reduced_g_);
  if (!core.allFinite()) throw Diverged("the step of the window is not finite");
  std::vector<Eigen::VectorXd> parts;
  for (const Group& group : groups_) {
    const Eigen::VectorXd tied = core(group.core_columns);
    parts.push_back(-group.llt.solve(group.g + group.W * tied));
  }
  Step step;
  for (const auto& [id, place] : places_) {
    const Eigen::VectorXd& source =
        place.group < 0 ? core : parts[static_cast<std::size_t>(place.group)];
    step[id] = source.segment(place.offset, place.dim);
  }
  return step;
}

double NormalEquations::slope(const Step& step) const {
  double sum = 0.0;
  for (const auto& [id, place] : places_) {
    const Eigen::VectorXd& g =
        place.group < 0 ? g_ : groups_[static_cast<std::size_t>(place.group)].g;
    sum += g.segment(place.offset, place.dim).dot(step.at(id));
  }
  return sum;
}

// With C the form's columns in the core once its group is eliminated, and E those in the group,
// J Sigma J' = C' S^-1 C + E' V^-1 E.
std::vector<Eigen::MatrixXd> NormalEquations::covariances(
    const std::vector<LinearForm>& forms) const {
  Eigen::Index total = 0;
  for (const LinearForm& form : forms) total += form.J.rows();
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(core_dim_, total);
  std::vector<Eigen::MatrixXd> result;
  Eigen::Index column = 0;
  for (const LinearForm& form : forms) {
    const Eigen::Index rows = form.J.rows();
    auto C_form = C.middleCols(column, rows);
    const Group* group = nullptr;
    Eigen::MatrixXd E;
    Eigen::Index at = 0;
    for (const VariableId id : form.variables) {
      const Place& place = places_.at(id);
      const auto J_t = form.J.middleCols(at, place.dim).transpose();
      at += place.dim;
      if (place.group < 0) {
        C_form.middleRows(place.offset, place.dim) += J_t;
        continue;
      }
      group = &groups_[static_cast<std::size_t>(place.group)];
      if (E.size() == 0) E.setZero(group->dim, rows);
      E.middleRows(place.offset, place.dim) += J_t;
    }
    result.emplace_back(Eigen::MatrixXd::Zero(rows, rows));
    if (group) {
      const Eigen::MatrixXd X = group->llt.solve(E);
      const Eigen::MatrixXd tied = group->W.transpose() * X;
      for (std::size_t i = 0; i < group->core_columns.size(); ++i) {
        C_form.row(group->core_columns[i]) -= tied.row(static_cast<Eigen::Index>(i));
      }
      result.back() = E.transpose() * X;
    }
    column += rows;
  }
  core_.matrixL().solveInPlace(C);
  column = 0;
  for (Eigen::MatrixXd& P : result) {
    const auto Y = C.middleCols(column, P.rows());
    P += Y.transpose() * Y;
    column += P.rows();
  }
  return result;
}

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

std::vector<Eigen::MatrixXd> NormalEquations::covariances(
    const std::vector<std::vector<VariableId>>& sets) const {
  std::vector<LinearForm> forms;
  for (const auto& set : sets) {
    int dim = 0;
    for (const VariableId id : set) dim += places_.at(id).dim;
    forms.push_back({set, Eigen::MatrixXd::Identity(dim, dim)});
  }
  return covariances(forms);
}

}  // namespace slammot
