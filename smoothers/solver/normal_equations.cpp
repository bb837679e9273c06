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
  eliminate_blocks(damping);
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
  for (const MarginalPrior::Block& b : graph.prior().active.blocks()) {
    to_core(b.variable->id, b.dim());
  }
  std::unordered_map<int, int> block_of_owner;
  auto next = places_.begin();
  for (const auto& [id, v] : graph.variables()) {
    Place& here = next++->second;
    if (here.dim > 0) continue;  // in the prior
    if (v.owner < 0) {
      to_core(id, v.dim());
      continue;
    }
    const auto [it, is_new] = block_of_owner.try_emplace(v.owner, static_cast<int>(blocks_.size()));
    if (is_new) blocks_.emplace_back();
    const auto k = static_cast<std::size_t>(it->second);
    here = blocks_[k].add_variable(it->second, v.dim(), here.part == Place::Part::kNoises);
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

void NormalEquations::add_prior(const Graph& graph) {
  const MarginalPrior& prior = graph.prior().active;
  const int n = prior.cols();
  if (n > 0) prior.normal_equations(U_.topLeftCorner(n, n), g_.head(n));
}

void NormalEquations::add_factors(const Graph& graph) {
  reduced_g_ = g_;
  std::vector<const Place*> all;  // of one factor after the other
  std::vector<int> block;         // of each factor: its Schur block, or -1
  for (const auto& [id, factor] : graph.factors()) {
    block.push_back(-1);
    for (const VariableId v : factor.variables) {
      all.push_back(&place(v));
      block.back() = std::max(block.back(), all.back()->block);
    }
    if (block.back() < 0) continue;
    const Places places = std::span(all).last(factor.variables.size());
    blocks_[static_cast<std::size_t>(block.back())].tie(places, factor.r.size());
  }
  for (SchurBlock& b : blocks_) b.begin();
  auto of_factor = block.begin();
  std::span<const Place* const> rest(all);
  for (const auto& [id, factor] : graph.factors()) {
    const Places places = rest.first(factor.variables.size());
    rest = rest.subspan(places.size());
    if (*of_factor >= 0) blocks_[static_cast<std::size_t>(*of_factor)].add(factor, places);
    add_to_core(factor, places);
    ++of_factor;
  }
}

// What a factor says of the core. Where noises of a block stand beside it, H gets it once these are
// eliminated.
void NormalEquations::add_to_core(const Factor& factor, Places places) {
  const bool has_noise = SchurBlock::has_noise(places);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& a = *places[i];
    if (a.block >= 0) continue;
    const auto J_t = factor.jacobian(i).transpose();
    const SmallVector g = J_t.lazyProduct(factor.r);
    g_.segment(a.offset, a.dim) += g;
    if (has_noise) continue;
    reduced_g_.segment(a.offset, a.dim) += g;
    for (std::size_t j = 0; j < places.size(); ++j) {
      const Place& b = *places[j];
      if (b.block >= 0 || b.offset > a.offset) continue;  // U's lower triangle
      U_.block(a.offset, b.offset, a.dim, b.dim) += J_t.lazyProduct(factor.jacobian(j));
    }
  }
}

void NormalEquations::eliminate_blocks(double damping) {
  Eigen::VectorXd squares = U_.diagonal();
  for (SchurBlock& block : blocks_) {
    block.eliminate(damping);
    const std::vector<int>& columns = block.core_columns();
    if (damping > 0.0) squares(columns) += block.core_squares();
    reduced_g_(columns) += block.core_gradient();
    const auto n = std::ssize(columns);
    for (Eigen::Index j = 0; j < n; ++j) {
      double* column = &U_(0, columns[static_cast<std::size_t>(j)]);
      const auto of_block = block.core_information().col(j);
      for (Eigen::Index i = j; i < n; ++i)
        column[columns[static_cast<std::size_t>(i)]] += of_block(i);
    }
  }
  U_.diagonal() += damping * squares;
}

Eigen::VectorXd NormalEquations::part(const Place& at, const Eigen::VectorXd& core,
                                      const std::vector<SchurBlock::Part>& blocks) const {
  if (at.block < 0) return core.segment(at.offset, at.dim);
  const SchurBlock::Part& block = blocks[static_cast<std::size_t>(at.block)];
  const bool is_noise = at.part == Place::Part::kNoises;
  return (is_noise ? block.noises : block.states).segment(at.offset, at.dim);
}

Step NormalEquations::step() const {
  const Eigen::VectorXd core = -core_.solve(reduced_g_);
  if (!core.allFinite()) throw Diverged("the step of the window is not finite");
  std::vector<SchurBlock::Part> parts;
  for (const SchurBlock& block : blocks_) parts.push_back(block.step(core));
  Step step;
  for (const auto& [id, at] : places_) step[id] = part(at, core, parts);
  return step;
}

double NormalEquations::predicted_decrease(const Step& step) const {
  std::vector<SchurBlock::Part> parts;
  for (const SchurBlock& block : blocks_) parts.push_back(block.gradient());
  double sum = 0.0;
  for (const auto& [id, at] : places_) sum += part(at, g_, parts).dot(step.at(id));
  return -sum;
}

// Brings C from the projection's columns in the core to what they are once its block is eliminated;
// returns what the block adds to the covariance.
Eigen::MatrixXd NormalEquations::eliminate_block(const StateProjection& projection,
                                                 Eigen::Ref<Eigen::MatrixXd> C) const {
  const Eigen::Index rows = projection.J.rows();
  const SchurBlock* block = nullptr;
  Eigen::MatrixXd E_states, E_noises;
  Eigen::Index at = 0;
  for (const VariableId id : projection.variables) {
    const Place& p = place(id);
    const auto J_t = projection.J.middleCols(at, p.dim).transpose();
    at += p.dim;
    if (p.block < 0) {
      C.middleRows(p.offset, p.dim) += J_t;
      continue;
    }
    if (!block) {
      block = &blocks_[static_cast<std::size_t>(p.block)];
      E_states.setZero(block->states(), rows);
      E_noises.setZero(block->noises(), rows);
    }
    const bool is_noise = p.part == Place::Part::kNoises;
    (is_noise ? E_noises : E_states).middleRows(p.offset, p.dim) += J_t;
  }
  if (!block) return Eigen::MatrixXd::Zero(rows, rows);
  Eigen::MatrixXd tied = C(block->core_columns(), Eigen::all);
  Eigen::MatrixXd P = block->covariance(E_states, E_noises, tied);
  C(block->core_columns(), Eigen::all) = tied;
  return P;
}

// J Sigma J' is what the block adds and C' S^-1 C.
std::vector<Eigen::MatrixXd> NormalEquations::covariances(
    const std::vector<StateProjection>& projections) const {
  if (projections.empty()) return {};
  Eigen::Index total = 0;
  for (const StateProjection& projection : projections) total += projection.J.rows();
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(core_dim_, total);
  std::vector<Eigen::MatrixXd> result;
  Eigen::Index column = 0;
  for (const StateProjection& projection : projections) {
    const Eigen::Index rows = projection.J.rows();
    result.push_back(eliminate_block(projection, C.middleCols(column, rows)));
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
  std::vector<StateProjection> projections;
  for (const auto& set : sets) {
    int dim = 0;
    for (const VariableId id : set) dim += place(id).dim;
    projections.push_back({set, Eigen::MatrixXd::Identity(dim, dim)});
  }
  return covariances(projections);
}

}  // namespace slammot
