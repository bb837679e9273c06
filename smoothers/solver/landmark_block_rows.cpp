// The rows of a landmark, before it is eliminated: pixels along its chain, birth and prior.
#include "smoothers/solver/landmark_block.h"

namespace slammot {

void LandmarkBlock::lay_out(const Graph& graph, const GraphLandmark& l) {
  pixels_ = static_cast<int>(l.pixels.size());
  own_ =
      l.is_considered ? graph.prior().active.own_rows(l.y, l.w) : MarginalPrior::ConsideredRows{};
  rows_ = 2 * pixels_ + l.birth.rows() + static_cast<int>(l.w_prior.rows()) +
          static_cast<int>(own_.count);
  steps_ = l.steps();
  states_ = l.is_free() ? graph.models().landmark->dim() : 3;
  share_core(graph, l);
  independent_ = steps_ == 0 && first_private_ == states_;
  poses_.clear();
  for (const GraphPixel& pixel : l.pixels) poses_.push_back(graph.variables[pixel.position].core);
  A_.resize(rows_, 6);
  X_.resize(rows_, states_);
  S_.resize(rows_, shared_cols_);
  T_.resize(states_, rows_);
  P_.resize(rows_, rows_);
  q_.resize(rows_);
  e_.resize(rows_);
}

void LandmarkBlock::share_core(const Graph& graph, const GraphLandmark& l) {
  const Variable& y = graph.variables[l.y];
  shared_.clear();
  shared_cols_ = 0;
  first_private_ = 0;
  const auto share = [&](const Variable& v, bool is_state, int state) {
    shared_.push_back({v.core, shared_cols_, v.dim(), is_state, state});
    shared_cols_ += v.dim();
  };
  share(graph.variables[l.anchor], false, 0);
  if (!y.is_private && !l.is_considered) {
    share(y, true, 0);
    first_private_ = 3;
    if (l.is_free() && !graph.variables[l.w].is_private) {
      share(graph.variables[l.w], true, 3);
      first_private_ = states_;
    }
  }
  scene_column_ = shared_cols_;
  if (l.birth.kind == BirthPrior::Kind::kSharedDepth) {
    share(graph.variables[l.birth.scene], false, 0);
  }
  own_column_ = shared_cols_;
  if (own_.count == 0) return;
  for (const MarginalPrior::Run& run : graph.prior().active.runs()) {
    shared_.push_back({run.core, shared_cols_, run.dim, false, 0});
    shared_cols_ += run.dim;
  }
}

// The chain moves on by one step: the covariances of its newest state with the rows so far follow.
void LandmarkBlock::advance(const ChainStep& step, std::size_t index, Eigen::Index rows) {
  LandmarkMatrix GD = step.G;
  LandmarkVector drift = step.noise;
  if (!D_.empty()) {
    GD *= D_[index].cwiseInverse().asDiagonal();
    drift.array() /= D_[index].array();
  }
  drift_ = (step.F.lazyProduct(drift_) + step.G.lazyProduct(drift)).eval();
  const LandmarkMatrix FC = step.F.lazyProduct(C_);
  C_ = FC.lazyProduct(step.F.transpose());
  C_ += GD.lazyProduct(step.G.transpose());
  Phi_ = step.F.lazyProduct(Phi_).eval();
  auto T = *T_;
  for (Eigen::Index row = 0; row < rows; row += 2) {
    auto two = T.middleCols<2>(row);
    two = step.F.lazyProduct(two).eval();
  }
}

// What the noises of the chain are damped by: D = 1 + damping (1 + squares of N's columns).
void LandmarkBlock::damp_noises(const GraphLandmark& l, double damping) {
  D_.assign(damping > 0.0 ? l.chain.size() : 0, {});
  if (D_.empty()) return;
  LandmarkMatrix information = LandmarkMatrix::Zero(states_, states_);
  auto pixel = l.pixels.rbegin();
  for (int depth = l.steps(); depth > 0; --depth) {
    const ChainStep& step = l.chain[static_cast<std::size_t>(depth - 1)];
    for (; pixel != l.pixels.rend() && pixel->depth == depth; ++pixel) {
      information.topLeftCorner<3, 3>() += pixel->at.J_y.transpose() * pixel->at.J_y;
    }
    const LandmarkMatrix IG = information.lazyProduct(step.G);
    const LandmarkMatrix squares = step.G.transpose().lazyProduct(IG);
    D_[static_cast<std::size_t>(depth - 1)] =
        ((1.0 + damping) + damping * squares.diagonal().array()).matrix();
    const LandmarkMatrix IF = information.lazyProduct(step.F);
    information = step.F.transpose().lazyProduct(IF);
  }
}

void LandmarkBlock::fill_row(const GraphPixel& pixel, Eigen::Index row) {
  const auto J_y = pixel.at.J_y;
  (*A_).block<2, 6>(row, 0) = pixel.at.J_pose;
  (*X_).middleRows<2>(row) = J_y.lazyProduct(Phi_.topRows<3>());
  (*S_).middleRows<2>(row).leftCols<3>() = pixel.at.J_anchor;
  q_.segment<2>(row) = pixel.at.r;
  if (pixel.depth == 0) {
    (*T_).middleCols<2>(row).setZero();
    return;
  }
  q_.segment<2>(row) -= J_y * drift_.head<3>();
  auto M = *P_;
  auto T = *T_;
  T.middleCols<2>(row) = C_.leftCols<3>().lazyProduct(J_y.transpose());
  for (Eigen::Index j = 0; j <= row; j += 2) {
    M.block<2, 2>(row, j) += J_y * T.block<3, 2>(0, j);
  }
}

void LandmarkBlock::fill_birth(const GraphLandmark& l) {
  const int rows = l.birth.rows();
  if (rows == 0) return;
  const int first = 2 * pixels_;
  (*A_).middleRows(first, rows).setZero();
  (*X_).middleRows(first, rows).setZero();
  (*X_).middleRows(first, rows).leftCols<3>() = l.birth.J_y.topRows(rows);
  (*S_).middleRows(first, rows).leftCols<3>() = l.birth.J_anchor.topRows(rows);
  if (l.birth.kind == BirthPrior::Kind::kSharedDepth) {
    (*S_).middleRows(first, rows).col(scene_column_) = l.birth.J_scene.topRows(rows);
  }
  (*T_).middleCols(first, rows).setZero();
  q_.segment(first, rows) = l.birth.r.head(rows);
}

void LandmarkBlock::fill_prior_of_motion(const GraphLandmark& l) {
  const MotionPrior& at = l.w_prior;
  const Eigen::Index rows = at.rows(), first = 2 * pixels_ + l.birth.rows();
  if (rows == 0) return;
  (*A_).middleRows(first, rows).setZero();
  (*X_).middleRows(first, rows).leftCols<3>() = at.J_y;
  (*X_).middleRows(first, rows).rightCols(rows) = at.J_w.asDiagonal();
  (*T_).middleCols(first, rows).setZero();
  q_.segment(first, rows) = at.r;
}

void LandmarkBlock::fill_prior(const Graph& graph) {
  if (own_.count == 0) return;
  const MarginalPrior& prior = graph.prior().active;
  Eigen::MatrixXd rows;
  prior.fill_own(own_, q_.tail(own_.count), rows);
  auto X = (*X_).bottomRows(own_.count);
  (*A_).bottomRows(own_.count).setZero();
  X.setZero();
  X.leftCols<3>() = rows.middleCols<3>(own_.y);
  if (own_.w >= 0) X.rightCols(states_ - 3) = rows.middleCols(own_.w, states_ - 3);
  (*T_).rightCols(own_.count).setZero();
  Eigen::Index column = own_column_;
  for (const MarginalPrior::Run& run : prior.runs()) {
    (*S_).bottomRows(own_.count).middleCols(column, run.dim) = rows.middleCols(run.offset, run.dim);
    column += run.dim;
  }
}

void LandmarkBlock::fill(const Graph& graph, const GraphLandmark& l) {
  (*S_).setZero();
  if (!independent_) {
    (*P_).setIdentity();
  }
  Phi_.setIdentity(states_, states_);
  C_.setZero(states_, states_);
  drift_.setZero(states_);
  auto pixel = l.pixels.begin();
  Eigen::Index row = 0;
  for (int depth = 0; depth <= steps_; ++depth) {
    if (depth > 0)
      advance(l.chain[static_cast<std::size_t>(depth - 1)], static_cast<std::size_t>(depth - 1),
              row);
    for (; pixel != l.pixels.end() && pixel->depth == depth; ++pixel, row += 2) {
      fill_row(*pixel, row);
    }
  }
  fill_birth(l);
  fill_prior_of_motion(l);
  fill_prior(graph);
  auto S = *S_;
  for (const Shared& s : shared_) {
    if (s.is_state) S.middleCols(s.column, s.dim) = (*X_).middleCols(s.state, s.dim);
  }
}

}  // namespace slammot
