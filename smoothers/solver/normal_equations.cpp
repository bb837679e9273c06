#include "smoothers/solver/normal_equations.h"

#include <algorithm>
#include <stdexcept>
#include <unordered_map>

#include "estimation/estimator.h"

namespace slammot {

NormalEquations::NormalEquations(const Graph& graph, double damping) {
  place_variables(graph);
  add_prior(graph);
  add_factors(graph);
  eliminate_groups(damping);
  core_.compute(U_);
  if (core_.info() != Eigen::Success) {
    throw Diverged("the information matrix of the window is not positive definite");
  }
}

namespace {

// Of a landmark's private variable: it may be eliminated as a noise.
bool is_unit_prior(const Factor& factor) {
  return factor.variables.size() == 1 && factor.at.front()->owner >= 0 &&
         factor.J.rows() == factor.J.cols() && factor.J.isIdentity(0.0);
}

}  // namespace

void NormalEquations::place_variables(const Graph& graph) {
  for (const auto& [id, v] : graph.variables()) places_.emplace_back(id, Place{});
  const auto place_of = [&](VariableId id) -> Place& { return places_[index(id)].second; };
  const auto to_core = [&](VariableId id, int dim) {
    place_of(id) = {Place::Part::kCore, -1, core_dim_, dim};
    core_dim_ += dim;
  };
  for (const auto& [id, factor] : graph.factors()) {
    if (is_unit_prior(factor)) place_of(factor.variables.front()).part = Place::Part::kNoises;
  }
  for (const VariableId id : graph.prior().variables) to_core(id, graph.variables().at(id).dim());
  std::unordered_map<int, int> group_of_owner;
  auto next = places_.begin();
  for (const auto& [id, v] : graph.variables()) {
    Place& here = next++->second;
    if (here.dim > 0) continue;  // in the prior
    if (v.owner < 0) {
      to_core(id, v.dim());
      continue;
    }
    const auto [it, is_new] = group_of_owner.try_emplace(v.owner, static_cast<int>(groups_.size()));
    if (is_new) groups_.emplace_back();
    const auto k = static_cast<std::size_t>(it->second);
    here = groups_[k].add_variable(it->second, v.dim(), here.part == Place::Part::kNoises);
  }
  U_.setZero(core_dim_, core_dim_);
  g_.setZero(core_dim_);
}

std::size_t NormalEquations::index(VariableId id) const {
  const auto found =
      std::lower_bound(places_.begin(), places_.end(), id,
                       [](const auto& p, VariableId wanted) { return p.first < wanted; });
  if (found == places_.end() || found->first != id) {
    throw std::logic_error("a variable that is not in the graph has no place in its equations");
  }
  return static_cast<std::size_t>(found - places_.begin());
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
  reduced_g_ = g_;
  std::vector<const Place*> all;  // of one factor after the other
  std::vector<int> group;         // of each factor, or -1
  for (const auto& [id, factor] : graph.factors()) {
    group.push_back(-1);
    for (const VariableId v : factor.variables) {
      all.push_back(&place(v));
      group.back() = std::max(group.back(), all.back()->group);
    }
    if (group.back() < 0) continue;
    const Places places = std::span(all).last(factor.variables.size());
    groups_[static_cast<std::size_t>(group.back())].tie(places, factor.r.size());
  }
  for (LandmarkGroup& g : groups_) g.begin();
  auto of_factor = group.begin();
  std::span<const Place* const> rest(all);
  for (const auto& [id, factor] : graph.factors()) {
    const Places places = rest.first(factor.variables.size());
    rest = rest.subspan(places.size());
    if (*of_factor >= 0) groups_[static_cast<std::size_t>(*of_factor)].add(factor, places);
    add_to_core(factor, places);
    ++of_factor;
  }
}

// What a factor says of the core. Where noises of a group stand beside it, H gets it once these are
// eliminated.
void NormalEquations::add_to_core(const Factor& factor, Places places) {
  const bool has_noise = LandmarkGroup::has_noise(places);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& a = *places[i];
    if (a.group >= 0) continue;
    const auto J_t = factor.jacobian(i).transpose();
    const SmallVector g = J_t.lazyProduct(factor.r);
    g_.segment(a.offset, a.dim) += g;
    if (has_noise) continue;
    reduced_g_.segment(a.offset, a.dim) += g;
    for (std::size_t j = 0; j < places.size(); ++j) {
      const Place& b = *places[j];
      if (b.group >= 0 || b.offset > a.offset) continue;  // U's lower triangle
      U_.block(a.offset, b.offset, a.dim, b.dim) += J_t.lazyProduct(factor.jacobian(j));
    }
  }
}

void NormalEquations::eliminate_groups(double damping) {
  Eigen::VectorXd squares = U_.diagonal();
  for (LandmarkGroup& group : groups_) {
    group.eliminate(damping);
    const std::vector<int>& columns = group.columns();
    if (damping > 0.0) squares(columns) += group.squares();
    reduced_g_(columns) += group.gradient();
    const auto n = std::ssize(columns);
    for (Eigen::Index j = 0; j < n; ++j) {
      double* column = &U_(0, columns[static_cast<std::size_t>(j)]);
      const auto of_group = group.information().col(j);
      for (Eigen::Index i = j; i < n; ++i)
        column[columns[static_cast<std::size_t>(i)]] += of_group(i);
    }
  }
  U_.diagonal() += damping * squares;
}

Eigen::VectorXd NormalEquations::part(const Place& at, const Eigen::VectorXd& core,
                                      const std::vector<LandmarkGroup::Part>& groups) const {
  if (at.group < 0) return core.segment(at.offset, at.dim);
  const LandmarkGroup::Part& group = groups[static_cast<std::size_t>(at.group)];
  const bool is_noise = at.part == Place::Part::kNoises;
  return (is_noise ? group.noises : group.states).segment(at.offset, at.dim);
}

Step NormalEquations::step() const {
  const Eigen::VectorXd core = -core_.solve(reduced_g_);
  if (!core.allFinite()) throw Diverged("the step of the window is not finite");
  std::vector<LandmarkGroup::Part> parts;
  for (const LandmarkGroup& group : groups_) parts.push_back(group.step(core));
  Step step;
  for (const auto& [id, at] : places_) step[id] = part(at, core, parts);
  return step;
}

double NormalEquations::slope(const Step& step) const {
  std::vector<LandmarkGroup::Part> parts;
  for (const LandmarkGroup& group : groups_) parts.push_back(group.slope());
  double sum = 0.0;
  for (const auto& [id, at] : places_) sum += part(at, g_, parts).dot(step.at(id));
  return sum;
}

// With C the form's columns in the core once its group is eliminated, J Sigma J' is what the group
// adds and C' S^-1 C.
std::vector<Eigen::MatrixXd> NormalEquations::covariances(
    const std::vector<LinearForm>& forms) const {
  if (forms.empty()) return {};
  Eigen::Index total = 0;
  for (const LinearForm& form : forms) total += form.J.rows();
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(core_dim_, total);
  std::vector<Eigen::MatrixXd> result;
  Eigen::Index column = 0;
  for (const LinearForm& form : forms) {
    const Eigen::Index rows = form.J.rows();
    auto C_form = C.middleCols(column, rows);
    const LandmarkGroup* group = nullptr;
    Eigen::MatrixXd E_states, E_noises;
    Eigen::Index at = 0;
    for (const VariableId id : form.variables) {
      const Place& p = place(id);
      const auto J_t = form.J.middleCols(at, p.dim).transpose();
      at += p.dim;
      if (p.group < 0) {
        C_form.middleRows(p.offset, p.dim) += J_t;
        continue;
      }
      if (!group) {
        group = &groups_[static_cast<std::size_t>(p.group)];
        E_states.setZero(group->states(), rows);
        E_noises.setZero(group->noises(), rows);
      }
      const bool is_noise = p.part == Place::Part::kNoises;
      (is_noise ? E_noises : E_states).middleRows(p.offset, p.dim) += J_t;
    }
    result.emplace_back(Eigen::MatrixXd::Zero(rows, rows));
    if (group) {
      Eigen::MatrixXd tied = C_form(group->columns(), Eigen::all);
      result.back() = group->covariance(E_states, E_noises, tied);
      C_form(group->columns(), Eigen::all) = tied;
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

std::vector<Eigen::MatrixXd> NormalEquations::covariances(
    const std::vector<std::vector<VariableId>>& sets) const {
  std::vector<LinearForm> forms;
  for (const auto& set : sets) {
    int dim = 0;
    for (const VariableId id : set) dim += place(id).dim;
    forms.push_back({set, Eigen::MatrixXd::Identity(dim, dim)});
  }
  return covariances(forms);
}

}  // namespace slammot
