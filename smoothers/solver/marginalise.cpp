#include "smoothers/solver/marginalise.h"

#include <algorithm>

#include "smoothers/solver/camera_parts.h"

namespace slammot {

void Leaving::clear() {
  oldest.reset();
  departures.clear();
  anchors.clear();
  deactivated.clear();
  apart = -1;
}

void Marginaliser::take(Variable& v) {
  if (v.column >= 0 || v.is_considered) return;
  v.column = total_;
  total_ += v.dim();
  order_.push_back(&v);
}

// Variables that will be no more.
void Marginaliser::find_going(const Graph& graph, const Leaving& leaving) {
  going_.clear();
  if (leaving.oldest) going_ = {leaving.oldest->orientation, leaving.oldest->rates};
  going_.insert(going_.end(), leaving.anchors.begin(), leaving.anchors.end());
  for (const Departure& d : leaving.departures) {
    const GraphLandmark& l = graph[d.landmark];
    if (l.is_free() && (d.forgets_w || d.leaves)) going_.push_back(l.w);
    if (d.leaves) going_.push_back(l.y);
  }
}

// The noises of substitutions, what the prior holds and leaves, what else leaves, what is
// deactivated; then what moves on along its chain, what is new to the prior, and the rest of the
// prior as it was: its rows remain a triangle there. Considered landmarks have no columns.
void Marginaliser::order_columns(Graph& graph, const Leaving& leaving) {
  graph.variables.for_each([](Variable& v) { v.column = -1; });
  order_.clear();
  total_ = 0;
  for (std::size_t i = 0; i < local_count_; ++i) {
    if (is_considered(graph, i)) continue;
    locals_[i].noise_column = total_;
    total_ += locals_[i].noise_dim();
  }
  take_leaving(graph, leaving);
  gone_ = total_;
  for (std::size_t i = 0; i < local_count_; ++i) {
    const GraphLandmark& l = graph[locals_[i].departure().landmark];
    if (locals_[i].departure().steps == 0) continue;
    for (const VariableId id : {l.y, l.w}) {
      // What leaves and has no column is not in any row.
      if (!leaves_[static_cast<std::size_t>(id)]) take(graph.variables[id]);
    }
  }
  take_new(graph, leaving);
  for (const MarginalPrior::Block& b : graph.prior().active.blocks()) {
    take(graph.variables[b.variable->id]);
  }
}

void Marginaliser::take_leaving(Graph& graph, const Leaving& leaving) {
  leaves_.assign(graph.variables.size(), false);
  for (const VariableId id : going_) leaves_[static_cast<std::size_t>(id)] = true;
  const auto take_if_leaving = [&](VariableId id) {
    if (id >= 0 && leaves_[static_cast<std::size_t>(id)]) take(graph.variables[id]);
  };
  for (const MarginalPrior::Block& b : graph.prior().active.blocks()) {
    take_if_leaving(b.variable->id);
  }
  if (leaving.apart >= 0) {
    const GraphLandmark& l = graph[leaving.apart];
    for (const VariableId id : {l.y, l.w}) {
      if (graph.prior().active.find(id)) take(graph.variables[id]);
    }
  }
  for (std::size_t i = 0; i < local_count_; ++i) {
    for (const auto& s : locals_[i].segments()) take_if_leaving(s.variable);
  }
  if (leaving.oldest) {
    take(graph.variables[leaving.oldest->orientation]);
    take(graph.variables[leaving.oldest->rates]);
  }
  for (const VariableId id : leaving.anchors) take(graph.variables[id]);
  for (const VariableId id : leaving.deactivated) take(graph.variables[id]);
}

// What the prior has not held so far.
void Marginaliser::take_new(Graph& graph, const Leaving& leaving) {
  in_prior_.assign(graph.variables.size(), false);
  for (const MarginalPrior::Block& b : graph.prior().active.blocks()) {
    in_prior_[static_cast<std::size_t>(b.variable->id)] = true;
  }
  const auto take_if_new = [&](VariableId id) {
    if (id >= 0 && !in_prior_[static_cast<std::size_t>(id)]) take(graph.variables[id]);
  };
  for (std::size_t i = 0; i < local_count_; ++i) {
    for (const auto& s : locals_[i].segments()) take_if_new(s.variable);
  }
  if (!leaving.oldest) return;
  take_if_new(leaving.oldest->position);
  if (graph.motions.empty()) return;
  for (const CameraPart& p : parts(graph.motions.front().to)) take_if_new(p.variable);
}

void Marginaliser::update_landmark(Graph& graph, const LocalElimination& local,
                                   const Leaving& leaving) {
  const Departure& d = local.departure();
  GraphLandmark& l = graph[d.landmark];
  const VariableId oldest = leaving.oldest ? leaving.oldest->position : -1;
  if (d.steps > 0) {
    for (const VariableId id : {l.y, l.w}) graph.variables[id].linearisation_point.reset();
    graph.variables[l.y].value = local.next.head<3>();
    graph.variables[l.w].value = local.next.tail(local.next.size() - 3);
    l.chain.erase(l.chain.begin(), l.chain.begin() + d.steps);
  }
  if (d.all_rows || l.anchor == oldest) l.birth = {};
  std::erase_if(l.pixels, [&](const GraphPixel& p) { return d.takes(p, oldest); });
  for (GraphPixel& p : l.pixels) p.depth -= d.steps;
  if (d.absorbs_prior_of_w) l.w_prior = {};
  if (l.constrained) l.constrained->prior = {};
}

void Marginaliser::operator()(Graph& graph, const Leaving& leaving) {
  if (leaving.empty()) return;
  const VariableId oldest = leaving.oldest ? leaving.oldest->position : -1;
  local_count_ = leaving.departures.size();
  if (locals_.size() < local_count_) locals_.resize(local_count_);
  for (std::size_t i = 0; i < local_count_; ++i) {
    locals_[i].compute(graph, leaving.departures[i], oldest);
  }
  find_going(graph, leaving);
  order_columns(graph, leaving);
  ConditionalMap& map = graph.prior().inactive;
  map.relinearise(graph.prior().active, total_);
  graph.prior().active.relinearise();
  count_rows(graph, leaving);
  fill(graph, leaving);
  for (const VariableId id : leaving.deactivated) {
    Variable& v = graph.variables[id];
    if (graph.fixed_points()) v.keep_point();  // the prior may have touched it in this call only
    map.deactivate(v, v.column);
  }
  const Triangularise::Staircase rows = triangularise_(*A_, sorted_starts_, gone_, total_);
  update_map(graph, leaving, rows);
  compute_own(graph, leaving, rows);
  for (std::size_t i = 0; i < local_count_; ++i) update_landmark(graph, locals_[i], leaving);
  set_prior(graph, rows);
  remove(graph, leaving);
}

// Considered landmarks of which something leaves, or of which the prior knows.
void Marginaliser::compute_own(const Graph& graph, const Leaving& leaving,
                               const Triangularise::Staircase& rows) {
  own_count_ = 0;
  const auto gone_rows = (*A_).topRows(std::min<Eigen::Index>(rows.rows_of_first, gone_));
  for (std::size_t i = 0; i < graph.landmarks.size(); ++i) {
    const auto id = static_cast<LandmarkId>(i);
    const GraphLandmark& l = graph[id];
    if (!l.is_alive || !l.is_considered) continue;
    const auto last = locals_.begin() + static_cast<std::ptrdiff_t>(local_count_);
    const auto local = std::find_if(locals_.begin(), last, [&](const LocalElimination& other) {
      return other.departure().landmark == id;
    });
    if (local != last && local->departure().leaves) continue;
    if (local == last && graph.prior().active.find(l.y) == nullptr) continue;
    ConsideredMarginal& own = next_own();
    own.compute(graph, id, local == last ? nullptr : &*local, gone_, total_);
    own.eliminate(gone_rows);
  }
  if (leaving.apart >= 0) next_own().take(graph, leaving.apart, gone_rows);
}

ConsideredMarginal& Marginaliser::next_own() {
  if (owns_.size() == own_count_) owns_.emplace_back();
  return owns_[own_count_++];
}

// Considered landmarks first, each beside the core and no other, and then the core.
void Marginaliser::set_prior(Graph& graph, const Triangularise::Staircase& rows) {
  std::erase_if(order_, [&](const Variable* v) { return v->column < gone_; });
  const Eigen::Index kept = rows.rows - rows.rows_of_first;
  // A prior that says nothing touches nothing.
  if (kept == 0 && graph.prior().inactive.empty() && own_count_ == 0) order_.clear();
  const Eigen::Index cols = order_.empty() ? 0 : total_ - gone_;
  Eigen::Index own = 0;
  own_order_.clear();
  for (std::size_t i = 0; i < own_count_; ++i) {
    own += owns_[i].dim();
    for (const VariableId id : owns_[i].variables()) own_order_.push_back(&graph.variables[id]);
  }
  R_.resize(own + kept, own + cols + 1);
  auto R = (*R_).leftCols(own + cols);
  auto r = (*R_).col(own + cols);
  R.topRows(own).setZero();
  R.bottomLeftCorner(kept, own).setZero();
  R.bottomRightCorner(kept, cols) = (*A_).block(rows.rows_of_first, gone_, kept, cols);
  r.tail(kept) = (*A_).col(total_).segment(rows.rows_of_first, kept);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < own_count_; ++i) {
    const auto of = owns_[i].rows();
    const int dim = owns_[i].dim();
    R.block(row, row, dim, dim) = of.leftCols(dim);
    R.block(row, own, dim, cols) = of.middleCols(dim, cols);
    r.segment(row, dim) = of.col(of.cols() - 1);
    row += dim;
  }
  for (const GraphLandmark& l : graph.landmarks) {
    if (l.is_alive) graph.variables[l.y].tells_scale = !l.is_free();
  }
  order_.insert(order_.begin(), own_order_.begin(), own_order_.end());
  graph.prior().active.set(order_, R, r);
  graph.prior().inactive.add_independent(own);
}

// Variables that are gone, and the factors of the oldest camera.
void Marginaliser::remove(Graph& graph, const Leaving& leaving) {
  if (leaving.oldest) {
    graph.initial.reset();
    if (!graph.motions.empty()) graph.motions.erase(graph.motions.begin());
  }
  for (const Departure& d : leaving.departures) {
    GraphLandmark& l = graph[d.landmark];
    if (d.forgets_w && !d.leaves) l.w = -1;
  }
  for (const VariableId id : going_) graph.variables.remove(id);
  for (const Departure& d : leaving.departures) {
    if (d.leaves) graph.remove_landmark(d.landmark);
  }
  for (const VariableId id : leaving.deactivated) graph.variables[id].is_active = false;
}

}  // namespace slammot
