#include "smoothers/solver/local_elimination.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>

#include "smoothers/graph/chain_step.h"

namespace slammot {

void LocalElimination::compute(const Graph& graph, const Departure& departure, VariableId oldest) {
  departure_ = departure;
  const GraphLandmark& l = graph[departure.landmark];
  dim_ = l.is_free() ? graph.models().landmark->dim() : 3;
  noises_ = departure.steps > 0 ? dim_ * departure.steps : 0;
  substitutes_ = departure.steps > 0 && !graph.variables[l.y].is_private;
  follow_chain(graph, l);
  lay_out(graph, l, oldest);
  fill(l, oldest);
  if (substitutes_) rotate_noises();
  starts_.assign(static_cast<std::size_t>((*A_).rows()), 0);
  eliminated_rows_ = triangularise_(*A_, starts_, eliminated_, eliminated_).rows_of_first;
}

// x_d, and dx_0 = Psi dx_d + N dn. F is taken at the current estimate.
void LocalElimination::follow_chain(const Graph& graph, const GraphLandmark& l) {
  next = graph.variables[l.y].value;
  if (l.is_free()) next = landmark_state(graph.variables[l.y].value, graph.variables[l.w].value);
  Psi.setIdentity(dim_, dim_);
  N_.resize(dim_, noises_);
  for (int j = 0; j < departure_.steps; ++j) {
    const ChainStep& step = l.chain[static_cast<std::size_t>(j)];
    const LandmarkMatrix F = chain_jacobian(graph.models(), step, next, step.noise);
    Psi = (Psi * F.inverse()).eval();
    (*N_).middleCols(j * dim_, dim_) = -Psi.lazyProduct(noise_jacobian(graph.models(), step, next));
    next = advance(graph.models(), step, next, step.noise);
  }
}

// Columns: the noises, w and y at x_d, then what else the rows touch. Those that are eliminated
// come first; `segments_` lists the others.
void LocalElimination::lay_out(const Graph& graph, const GraphLandmark& l, VariableId oldest) {
  const int own = place_own(graph, l);
  const int columns = place_touched(graph, l, oldest, own);
  A_.resize(count_rows(l, oldest), columns + 1);
  (*A_).setZero();
}

// Returns the next column.
int LocalElimination::place_own(const Graph& graph, const GraphLandmark& l) {
  segments_.clear();
  int column = noises_;
  eliminated_ = substitutes_ ? noises_ - dim_ : noises_;
  if (substitutes_) segments_.push_back({-1, eliminated_, dim_});
  const auto place = [&](VariableId id, bool is_private, bool goes) {
    const int at = column, dim = graph.variables[id].dim();
    column += dim;
    if (is_private && goes) {
      eliminated_ = column;
    } else {
      segments_.push_back({id, at, dim});
    }
    return at;
  };
  w_column_ = -1;
  if (l.is_free() && (departure_.steps > 0 || departure_.absorbs_prior_of_w)) {
    w_column_ = place(l.w, graph.variables[l.w].is_private && !substitutes_,
                      departure_.forgets_w || departure_.leaves);
  }
  y_column_ = place(l.y, graph.variables[l.y].is_private, departure_.leaves);
  constrained_column_ = l.constrained ? place(l.constrained->w, false, false) : -1;
  return column;
}

// Of pixels and birth, from this column on. Returns the next.
int LocalElimination::place_touched(const Graph& graph, const GraphLandmark& l, VariableId oldest,
                                    int column) {
  const auto touch = [&](VariableId id) {
    const int dim = graph.variables[id].dim();
    if (std::ranges::find(segments_, id, &Segment::variable) != segments_.end()) return;
    segments_.push_back({id, column, dim});
    column += dim;
  };
  for (const GraphPixel& pixel : l.pixels) {
    if (!departure_.takes(pixel, oldest)) continue;
    if (!pixel.z.here) {
      touch(pixel.position);
      touch(l.anchor);
    }
    touch(pixel.orientation);
  }
  if (!takes_birth(l, oldest)) return column;
  if (l.birth.kind == BirthPrior::Kind::kKnown) touch(l.anchor);
  if (l.birth.kind == BirthPrior::Kind::kSharedDepth) touch(l.birth.scene);
  return column;
}

Eigen::Index LocalElimination::count_rows(const GraphLandmark& l, VariableId oldest) const {
  Eigen::Index rows = noises_;
  for (const GraphPixel& pixel : l.pixels) rows += departure_.takes(pixel, oldest) ? 2 : 0;
  if (takes_birth(l, oldest)) rows += l.birth.rows();
  if (departure_.absorbs_prior_of_w) rows += l.w_prior.rows();
  if (l.constrained) rows += l.constrained->prior.rows();
  return rows;
}

int LocalElimination::column_of(VariableId id) const {
  return std::ranges::find(segments_, id, &Segment::variable)->column;
}

// Rows that have this coefficient of x after `depth` steps: carried back to x_0 by the F of their
// linearisation, and from there on to x_d.
void LocalElimination::fill_on_state(Eigen::Index row, Eigen::Index rows, int depth,
                                     LandmarkMatrix coefficient, const GraphLandmark& l) {
  auto A = *A_;
  for (int j = depth; j-- > 0;) {
    const ChainStep& step = l.chain[static_cast<std::size_t>(j)];
    A.block(row, j * dim_, rows, dim_) = coefficient.lazyProduct(step.G);
    coefficient = (coefficient.lazyProduct(step.F)).eval();
  }
  if (noises_ > 0) A.block(row, 0, rows, noises_).noalias() += coefficient * *N_;
  coefficient = (coefficient.lazyProduct(Psi)).eval();
  A.block(row, y_column_, rows, 3) = coefficient.leftCols<3>();
  if (w_column_ >= 0) A.block(row, w_column_, rows, dim_ - 3) = coefficient.rightCols(dim_ - 3);
}

// Returns the next row.
Eigen::Index LocalElimination::fill_birth(Eigen::Index row, const GraphLandmark& l) {
  if (l.birth.rows() == 0) return row;
  auto A = *A_;
  const int rows = l.birth.rows();
  LandmarkMatrix on_state = LandmarkMatrix::Zero(rows, dim_);
  on_state.leftCols<3>() = l.birth.J_y.topRows(rows);
  fill_on_state(row, rows, 0, on_state, l);
  if (l.birth.kind == BirthPrior::Kind::kKnown) {
    A.block(row, column_of(l.anchor), rows, 3) = l.birth.J_anchor.topRows(rows);
  }
  if (l.birth.kind == BirthPrior::Kind::kSharedDepth) {
    A.block(row, column_of(l.birth.scene), rows, 1) = l.birth.J_scene.topRows(rows);
  }
  A.col(A.cols() - 1).segment(row, rows) = l.birth.r.head(rows);
  return row + rows;
}

void LocalElimination::fill(const GraphLandmark& l, VariableId oldest) {
  auto A = *A_;
  auto residual = A.col(A.cols() - 1);
  Eigen::Index row = 0;
  for (int j = 0; j < departure_.steps; ++j, row += dim_) {
    A.block(row, row, dim_, dim_).setIdentity();
    residual.segment(row, dim_) = l.chain[static_cast<std::size_t>(j)].noise;
  }
  for (const GraphPixel& pixel : l.pixels) {
    if (!departure_.takes(pixel, oldest)) continue;
    LandmarkMatrix on_state = LandmarkMatrix::Zero(2, dim_);
    on_state.leftCols<3>() = pixel.at.J_y;
    // One that has been released has not moved along its chain yet.
    if (l.is_free() && pixel.J_w.cols() > 0) on_state.rightCols(dim_ - 3) = pixel.J_w;
    fill_on_state(row, 2, pixel.depth, on_state, l);
    if (l.constrained) A.block(row, constrained_column_, 2, pixel.J_w.cols()) = pixel.J_w;
    if (!pixel.z.here) {
      A.block<2, 3>(row, column_of(pixel.position)) = pixel.at.J_pose.leftCols<3>();
      A.block<2, 3>(row, column_of(l.anchor)) += pixel.at.J_anchor;
    }
    A.block<2, 3>(row, column_of(pixel.orientation)) = pixel.at.J_pose.rightCols<3>();
    residual.segment<2>(row) = pixel.at.r;
    row += 2;
  }
  if (takes_birth(l, oldest)) row = fill_birth(row, l);
  if (l.constrained) {
    const MotionPrior& at = l.constrained->prior;
    A.block(row, constrained_column_, at.rows(), at.rows()) = at.J_w.asDiagonal();
  }
  const MotionPrior& at = l.w_prior;
  if (!departure_.absorbs_prior_of_w || at.rows() == 0) return;
  LandmarkMatrix on_state = LandmarkMatrix::Zero(at.rows(), dim_);
  on_state.leftCols<3>() = at.J_y;
  on_state.rightCols(at.rows()) = at.J_w.asDiagonal();
  fill_on_state(row, at.rows(), 0, on_state, l);
  residual.segment(row, at.rows()) = at.r;
}

// With N' = Q (T 0)', the noises Q'n are as independent as n, and only the first of them, T', are
// in dx_0. They stand last among the noises' columns.
void LocalElimination::rotate_noises() {
  noise_gain = (*N_).rightCols(dim_);
  if (departure_.steps == 1) return;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr((*N_).transpose());
  const Eigen::MatrixXd T = qr.matrixQR().topRows(dim_).triangularView<Eigen::Upper>();
  noise_gain = T.transpose();
  auto A = *A_;
  const Eigen::Index rest = A.rows() - noises_, others = noises_ - dim_;
  const Eigen::MatrixXd turned = A.block(noises_, 0, rest, noises_) * qr.householderQ();
  A.block(noises_, 0, rest, others) = turned.rightCols(others);
  A.block(noises_, others, rest, dim_) = turned.leftCols(dim_);
  auto residual = A.col(A.cols() - 1).head(noises_);
  const Eigen::VectorXd r = qr.householderQ().transpose() * residual;
  residual.head(others) = r.tail(others);
  residual.tail(dim_) = r.head(dim_);
}

}  // namespace slammot
