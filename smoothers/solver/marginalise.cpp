#include "smoothers/solver/marginalise.h"

#include <algorithm>
#include <numeric>

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

void Marginaliser::add_rows(int start, Eigen::Index count) {
  starts_.insert(starts_.end(), static_cast<std::size_t>(count), start);
}

// In the order in which fill() makes them, and then where each goes: by their first column.
void Marginaliser::count_rows(const Graph& graph, const Leaving& leaving) {
  starts_.clear();
  for (std::size_t i = 0; i < local_count_; ++i) {
    int start = total_;
    for (const auto& s : locals_[i].segments()) {
      start = std::min(
          start, s.variable >= 0 ? graph.variables[s.variable].column : locals_[i].noise_column);
    }
    add_rows(start, locals_[i].rows().rows());
  }
  if (leaving.oldest && graph.initial) {
    int start = total_;
    for (const CameraPart& p : parts(graph.initial->camera)) {
      start = std::min(start, graph.variables[p.variable].column);
    }
    add_rows(start, kCameraDim);
  }
  if (leaving.oldest && !graph.motions.empty()) {
    int start = total_;
    for (const GraphCamera* c : {&graph.motions.front().from, &graph.motions.front().to}) {
      for (const CameraPart& p : parts(*c)) {
        start = std::min(start, graph.variables[p.variable].column);
      }
    }
    add_rows(start, kCameraDim);
  }
  count_prior_rows(graph);
  row_.resize(starts_.size());
  std::vector<Eigen::Index>& by_start = by_start_;
  by_start.resize(starts_.size());
  std::iota(by_start.begin(), by_start.end(), 0);
  std::ranges::sort(by_start, {}, [&](Eigen::Index i) {
    return std::pair(starts_[static_cast<std::size_t>(i)], i);
  });
  sorted_starts_.clear();
  for (std::size_t i = 0; i < by_start.size(); ++i) {
    row_[static_cast<std::size_t>(by_start[i])] = static_cast<Eigen::Index>(i);
    sorted_starts_.push_back(starts_[static_cast<std::size_t>(by_start[i])]);
  }
}

// A row of the prior that begins at some block of it touches that block and all later ones.
void Marginaliser::count_prior_rows(const Graph& graph) {
  const MarginalPrior& prior = graph.prior().active;
  first_from_.assign(static_cast<std::size_t>(prior.cols()) + 1, total_);
  const auto from = [&](int column) -> int& {
    return first_from_[static_cast<std::size_t>(column)];
  };
  for (std::size_t k = prior.blocks().size(); k-- > 0;) {
    const MarginalPrior::Block& b = prior.blocks()[k];
    int start = std::min(b.variable->column, from(b.offset + b.dim()));
    for (std::size_t i = 0; i < local_count_; ++i) {
      if (!locals_[i].substitutes()) continue;
      const GraphLandmark& l = graph[locals_[i].departure().landmark];
      if (l.y == b.variable->id || l.w == b.variable->id) {
        start = std::min(start, locals_[i].noise_column);
      }
    }
    for (int i = 0; i < b.dim(); ++i) {
      from(b.offset + i) = start;
    }
  }
  for (const int start : prior.starts()) {
    starts_.push_back(first_from_[static_cast<std::size_t>(start)]);
  }
}

void Marginaliser::fill(const Graph& graph, const Leaving& leaving) {
  A_.resize(std::ssize(starts_), total_ + 1);
  auto A = *A_;
  A.setZero();
  auto row = row_.begin();
  const auto put = [&](const auto& block, Eigen::Index column) {
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
      A.row(*(row + i)).segment(column, block.cols()) += block.row(i);
    }
  };
  for (std::size_t k = 0; k < local_count_; ++k) {
    const auto rows = locals_[k].rows();
    for (const auto& s : locals_[k].segments()) {
      const int column =
          s.variable >= 0 ? graph.variables[s.variable].column : locals_[k].noise_column;
      put(rows.middleCols(s.column, s.dim), column);
    }
    put(rows.col(locals_[k].residual_column()), total_);
    row += rows.rows();
  }
  const auto put_camera = [&](const GraphCamera& c, const Matrix12d& J) {
    for (const CameraPart& p : parts(c)) {
      put(J.middleCols(p.column, p.dim), graph.variables[p.variable].column);
    }
  };
  if (leaving.oldest && graph.initial) {
    put_camera(graph.initial->camera, graph.initial->J);
    put(graph.initial->r, total_);
    row += kCameraDim;
  }
  if (leaving.oldest && !graph.motions.empty()) {
    const CameraMotionFactor& motion = graph.motions.front();
    put_camera(motion.from, motion.J_from);
    put_camera(motion.to, motion.J_to);
    put(motion.r, total_);
    row += kCameraDim;
  }
  fill_prior(graph, row - row_.begin());
}

void Marginaliser::fill_prior(const Graph& graph, Eigen::Index first) {
  const MarginalPrior& prior = graph.prior().active;
  if (prior.cols() == 0) return;
  const auto R = prior.R();
  // Rows that begin later are zero in a block's columns.
  const auto rows_until = [&](int column) {
    return std::ranges::lower_bound(prior.starts(), column) - prior.starts().begin();
  };
  const auto put = [&](const auto& columns, Eigen::Index to) {
    for (Eigen::Index k = 0; k < columns.cols(); ++k) {
      double* column = (*A_).col(to + k).data();
      for (Eigen::Index i = 0; i < columns.rows(); ++i) {
        column[row_[static_cast<std::size_t>(first + i)]] = columns(i, k);
      }
    }
  };
  for (const MarginalPrior::Block& b : prior.blocks()) {
    put(R.middleCols(b.offset, b.dim()).topRows(rows_until(b.offset + b.dim())),
        b.variable->column);
  }
  put(prior.r(), total_);
  // dx_0 = Psi dx_d + noise_gain dn in the columns of what moves on.
  for (std::size_t k = 0; k < local_count_; ++k) {
    const LocalElimination& local = locals_[k];
    if (!local.substitutes()) continue;
    const GraphLandmark& l = graph[local.departure().landmark];
    const int y = graph.variables[l.y].column, w = graph.variables[l.w].column;
    const MarginalPrior::Block* y_0 = prior.find(l.y);
    const MarginalPrior::Block* w_0 = prior.find(l.w);
    const Eigen::Index dim = local.Psi.rows(), motion = dim - 3;
    const int end = std::max(y_0->offset + 3, w_0 ? w_0->offset + w_0->dim() : 0);
    const auto J = R.topRows(rows_until(end));
    moved_.resize(J.rows(), 2 * dim);
    auto of_x = (*moved_).leftCols(dim), of_noise = (*moved_).rightCols(dim);
    of_x = J.middleCols<3>(y_0->offset).lazyProduct(local.Psi.topRows<3>());
    of_noise = J.middleCols<3>(y_0->offset).lazyProduct(local.noise_gain.topRows<3>());
    if (w_0) {
      const auto J_w = J.middleCols(w_0->offset, motion);
      of_x += J_w.lazyProduct(local.Psi.bottomRows(motion));
      of_noise += J_w.lazyProduct(local.noise_gain.bottomRows(motion));
    }
    put(of_x.leftCols<3>(), y);
    put(of_x.rightCols(motion), w);
    put(of_noise, local.noise_column);
  }
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
