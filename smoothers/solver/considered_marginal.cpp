#include "smoothers/solver/considered_marginal.h"

#include <algorithm>

namespace slammot {

void ConsideredMarginal::compute(const Graph& graph, LandmarkId id, const LocalElimination* local,
                                 int gone, int total) {
  id_ = id;
  gone_ = gone;
  core_ = total;
  find_own(graph, local);
  const GraphLandmark& l = graph[id];
  const MarginalPrior::ConsideredRows in_prior = graph.prior().active.own_rows(l.y, l.w);
  const Eigen::Index of_local = local ? local->rows().rows() : 0;
  A_.resize(of_local + in_prior.count, before_ + dim_ + core_ + 1);
  (*A_).setZero();
  if (local) fill_local(graph, *local);
  if (in_prior.count > 0) fill_prior(graph, local, of_local);
  reduce(A_, before_, before_ + dim_);
}

void ConsideredMarginal::take(const Graph& graph, LandmarkId id,
                              const Eigen::Ref<const Eigen::MatrixXd>& rows) {
  id_ = id;
  core_ = static_cast<int>(rows.cols()) - 1;
  gone_ = 0;
  find_own(graph, nullptr);
  core_ -= dim_;
  result_.resize(dim_, rows.cols());
  (*result_).setZero();
  (*result_).topRows(rows.rows()) = rows;
}

void ConsideredMarginal::find_own(const Graph& graph, const LocalElimination* local) {
  own_.clear();
  const GraphLandmark& l = graph[id_];
  dim_ = 0;
  before_ = local ? local->noise_dim() : 0;
  for (const VariableId id : {l.y, l.w}) {
    const bool is_touched =
        local && std::ranges::find(local->segments(), id, &LocalElimination::Segment::variable) !=
                     local->segments().end();
    if (!is_touched && graph.prior().active.find(id) == nullptr) continue;
    own_.push_back(id);
    dim_ += graph.variables[id].dim();
  }
}

int ConsideredMarginal::own_column(VariableId id) const {
  if (!own_.empty() && own_.front() == id) return before_;
  return own_.size() > 1 && own_.back() == id ? before_ + 3 : -1;
}

void ConsideredMarginal::fill_local(const Graph& graph, const LocalElimination& local) {
  const auto rows = local.rows();
  auto A = (*A_).topRows(rows.rows());
  for (const LocalElimination::Segment& s : local.segments()) {
    int column = 0;  // the noise's
    if (s.variable >= 0) {
      const int own = own_column(s.variable);
      column = own >= 0 ? own : before_ + dim_ + graph.variables[s.variable].column;
    }
    A.middleCols(column, s.dim) += rows.middleCols(s.column, s.dim);
  }
  A.rightCols<1>() = rows.col(local.residual_column());
}

// With dx_0 = Psi dx_d + noise_gain dn where its base moves on.
void ConsideredMarginal::fill_prior(const Graph& graph, const LocalElimination* local,
                                    Eigen::Index first) {
  const MarginalPrior& prior = graph.prior().active;
  const GraphLandmark& l = graph[id_];
  const MarginalPrior::ConsideredRows at = prior.own_rows(l.y, l.w);
  const auto R = prior.R().middleRows(at.first, at.count);
  auto A = (*A_).middleRows(first, at.count);
  for (const MarginalPrior::Block& b : prior.blocks()) {
    if (b.variable->column < 0) continue;
    A.middleCols(before_ + dim_ + b.variable->column, b.dim()) = R.middleCols(b.offset, b.dim());
  }
  A.rightCols<1>() = prior.r().segment(at.first, at.count);
  const int motion = graph.models().landmark->motion;
  if (!local || !local->substitutes()) {
    A.middleCols<3>(before_) = R.middleCols<3>(at.y);
    if (at.w >= 0) A.middleCols(before_ + 3, motion) = R.middleCols(at.w, motion);
    return;
  }
  LandmarkMatrix on_state = LandmarkMatrix::Zero(at.count, 3 + motion);
  on_state.leftCols<3>() = R.middleCols<3>(at.y);
  if (at.w >= 0) on_state.rightCols(motion) = R.middleCols(at.w, motion);
  A.leftCols(before_) = on_state * local->noise_gain;
  A.middleCols(before_, dim_) = on_state * local->Psi;
}

// The rows of o, in `result_`: those in which a column of [first, last) stands first.
void ConsideredMarginal::reduce(GrowingMatrix& A, int first, int last) {
  starts_.resize(static_cast<std::size_t>((*A).rows()), 0);
  const Triangularise::Staircase at = triangularise_(*A, starts_, first, last);
  const Eigen::Index kept = std::min<Eigen::Index>(at.rows - at.rows_of_first, dim_);
  result_.resize(dim_, (*A).cols() - first);
  (*result_).setZero();
  (*result_).topRows(kept) = (*A).block(at.rows_of_first, first, kept, (*A).cols() - first);
}

void ConsideredMarginal::eliminate(const Eigen::Ref<const Eigen::MatrixXd>& gone_rows) {
  if (gone_ == 0) return;
  const auto own = *result_;
  const Eigen::Index after = core_ - gone_ + 1;
  B_.resize(dim_ + gone_rows.rows(), gone_ + dim_ + after);
  auto B = *B_;
  B.setZero();
  B.topLeftCorner(dim_, gone_) = own.middleCols(dim_, gone_);
  B.block(0, gone_, dim_, dim_) = own.leftCols(dim_);
  B.topRightCorner(dim_, after) = own.rightCols(after);
  B.bottomLeftCorner(gone_rows.rows(), gone_) = gone_rows.leftCols(gone_);
  B.bottomRightCorner(gone_rows.rows(), after) = gone_rows.rightCols(after);
  starts_.assign(static_cast<std::size_t>(B.rows()), 0);
  reduce(B_, gone_, gone_ + dim_);
}

}  // namespace slammot
