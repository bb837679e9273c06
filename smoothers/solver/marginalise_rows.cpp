// The rows of a marginalisation: where each begins and goes, and what is in it.
#include <algorithm>
#include <numeric>

#include "smoothers/solver/camera_parts.h"
#include "smoothers/solver/marginalise.h"

namespace slammot {

void Marginaliser::add_rows(int start, Eigen::Index count) {
  starts_.insert(starts_.end(), static_cast<std::size_t>(count), start);
}

// In the order in which fill() makes them.
void Marginaliser::count_rows(const Graph& graph, const Leaving& leaving) {
  starts_.clear();
  for (std::size_t i = 0; i < local_count_; ++i) {
    if (is_considered(graph, i)) continue;
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
  sort_rows();
}

// Where each goes: by their first column.
void Marginaliser::sort_rows() {
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

// A row of the prior that begins at some block of it touches that block and all later ones. Those
// of considered landmarks are left empty.
void Marginaliser::count_prior_rows(const Graph& graph) {
  const MarginalPrior& prior = graph.prior().active;
  first_from_.assign(static_cast<std::size_t>(prior.cols()) + 1, total_);
  const auto from = [&](int column) -> int& {
    return first_from_[static_cast<std::size_t>(column)];
  };
  for (std::size_t k = prior.blocks().size(); k-- > 0;) {
    const MarginalPrior::Block& b = prior.blocks()[k];
    const int after = from(b.offset + b.dim());
    int start = b.variable->is_considered ? after : std::min(b.variable->column, after);
    for (std::size_t i = 0; i < local_count_; ++i) {
      if (!locals_[i].substitutes() || is_considered(graph, i)) continue;
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
    if (is_considered(graph, k)) continue;
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
    if (b.variable->is_considered) continue;
    put(R.middleCols(b.offset, b.dim()).topRows(rows_until(b.offset + b.dim())),
        b.variable->column);
  }
  put(prior.r(), total_);
  // dx_0 = Psi dx_d + noise_gain dn in the columns of what moves on.
  for (std::size_t k = 0; k < local_count_; ++k) {
    const LocalElimination& local = locals_[k];
    if (!local.substitutes() || is_considered(graph, k)) continue;
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
  for (const MarginalPrior::Block& b : prior.blocks()) {
    if (!b.variable->is_considered) continue;
    const MarginalPrior::ConsideredRows own = prior.own_rows(b.variable->id, -1);
    for (Eigen::Index i = 0; i < own.count; ++i) {
      (*A_).row(row_[static_cast<std::size_t>(first + own.first + i)]).setZero();
    }
  }
}

}  // namespace slammot
