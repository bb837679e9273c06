#include "smoothers/solver/marginalise.h"

#include <algorithm>

#include "smoothers/solver/camera_parts.h"

namespace slammot {

namespace {

// Marks in Variable::column, before a column is given.
constexpr int kNone = -1, kLeaving = -2, kInPrior = -3;

}  // namespace

void Leaving::clear() {
  oldest.reset();
  departures.clear();
  anchors.clear();
  deactivated.clear();
}

void Marginaliser::take(Variable& v) {
  if (v.column >= 0) return;
  v.column = total_;
  total_ += v.dim();
  order_.push_back(&v);
}

// The noises of substitutions, what the prior holds and leaves, what else leaves, what is
// deactivated; then what moves on along its chain, what is new to the prior, and the rest of the
// prior as it was: its rows remain a triangle there.
void Marginaliser::order_columns(Graph& graph, const Leaving& leaving) {
  graph.variables.for_each([](Variable& v) { v.column = kNone; });
  order_.clear();
  total_ = 0;
  std::vector<VariableId>& going = going_;
  going.clear();
  if (leaving.oldest) going = {leaving.oldest->orientation, leaving.oldest->rates};
  going.insert(going.end(), leaving.anchors.begin(), leaving.anchors.end());
  for (const Departure& d : leaving.departures) {
    const GraphLandmark& l = graph[d.landmark];
    if (l.is_free() && (d.forgets_w || d.leaves)) going.push_back(l.w);
    if (d.leaves) going.push_back(l.y);
  }
  for (const VariableId id : going) graph.variables[id].column = kLeaving;
  const auto& blocks = graph.prior().active.blocks();
  for (std::size_t i = 0; i < local_count_; ++i) {
    locals_[i].noise_column = total_;
    total_ += locals_[i].noise_dim();
  }
  for (const MarginalPrior::Block& b : blocks) {
    Variable& v = graph.variables[b.variable->id];
    if (v.column == kLeaving) take(v);
  }
  const auto touched = [&](auto&& function) {
    for (std::size_t i = 0; i < local_count_; ++i) {
      for (const auto& s : locals_[i].segments()) {
        if (s.variable >= 0) function(graph.variables[s.variable]);
      }
    }
  };
  touched([&](Variable& v) {
    if (v.column == kLeaving) take(v);
  });
  if (leaving.oldest) {
    take(graph.variables[leaving.oldest->orientation]);
    take(graph.variables[leaving.oldest->rates]);
  }
  for (const VariableId id : leaving.anchors) take(graph.variables[id]);
  for (const VariableId id : leaving.deactivated) take(graph.variables[id]);
  gone_ = total_;
  for (std::size_t i = 0; i < local_count_; ++i) {
    const GraphLandmark& l = graph[locals_[i].departure().landmark];
    if (locals_[i].departure().steps == 0) continue;
    if (graph.variables[l.y].column == kNone) take(graph.variables[l.y]);
    if (graph.variables[l.w].column == kNone) take(graph.variables[l.w]);
  }
  for (const MarginalPrior::Block& b : blocks) {
    Variable& v = graph.variables[b.variable->id];
    if (v.column == kNone) v.column = kInPrior;
  }
  const auto take_new = [&](Variable& v) {
    if (v.column == kNone) take(v);
  };
  touched(take_new);
  if (leaving.oldest) {
    take_new(graph.variables[leaving.oldest->position]);
    if (!graph.motions.empty()) {
      for (const CameraPart& p : parts(graph.motions.front().to)) {
        take_new(graph.variables[p.variable]);
      }
    }
  }
  for (const MarginalPrior::Block& b : blocks) take(graph.variables[b.variable->id]);
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
  std::erase_if(l.pixels, [&](const GraphPixel& p) { return d.all_rows || p.position == oldest; });
  for (GraphPixel& p : l.pixels) p.depth -= d.steps;
  if (d.absorbs_prior_of_w) l.w_sigmas.resize(0);
  if (l.held) l.held->sigmas.resize(0);
}

void Marginaliser::operator()(Graph& graph, const Leaving& leaving) {
  if (leaving.empty()) return;
  const VariableId oldest = leaving.oldest ? leaving.oldest->position : -1;
  local_count_ = leaving.departures.size();
  if (locals_.size() < local_count_) locals_.resize(local_count_);
  for (std::size_t i = 0; i < local_count_; ++i) {
    locals_[i].compute(graph, leaving.departures[i], oldest);
  }
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

  for (std::size_t i = 0; i < local_count_; ++i) update_landmark(graph, locals_[i], leaving);
  std::erase_if(order_, [&](const Variable* v) { return v->column < gone_; });
  const Eigen::Index kept = rows.rows - rows.rows_of_first;
  // A prior that says nothing touches nothing.
  if (kept == 0 && map.empty()) order_.clear();
  const Eigen::Index cols = order_.empty() ? 0 : total_ - gone_;
  graph.prior().active.set(order_, (*A_).block(rows.rows_of_first, gone_, kept, cols),
                           (*A_).col(total_).segment(rows.rows_of_first, kept));
  remove(graph, leaving);
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
