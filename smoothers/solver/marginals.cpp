// Marginals from a factorisation of the normal equations.
#include <algorithm>

#include "smoothers/linear/lapack.h"
#include "smoothers/solver/camera_parts.h"
#include "smoothers/solver/normal_equations.h"

namespace slammot {

// Of the rows from the newest camera on: above them it is zero.
void NormalEquations::compute_camera() {
  if (camera_columns_.cols() > 0) return;
  const int rows = core_dim_ - newest_core_;
  camera_columns_.resize(rows, kCameraDim);
  auto C = *camera_columns_;
  C.setZero();
  C.block<3, 3>(camera_core_[0] - newest_core_, kPosition).setIdentity();
  C.block<3, 3>(camera_core_[1] - newest_core_, kRotation) = turn_.transpose();
  C.block<6, 6>(camera_core_[2] - newest_core_, kVelocity).setIdentity();
  solve_lower_in_place((*S_).bottomRightCorner(rows, rows), C);
  camera_covariance_.noalias() = C.transpose() * C;
}

Matrix12d NormalEquations::camera_covariance(const Graph& graph, const GraphCamera& camera) const {
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(core_dim_, kCameraDim);
  for (const CameraPart& p : parts(camera)) {
    C.block(graph.variables[p.variable].core, p.column, p.dim, p.dim).setIdentity();
  }
  solve_lower_in_place(*S_, C);
  return C.transpose() * C;
}

Matrix12d NormalEquations::camera_covariance() {
  compute_camera();
  return camera_covariance_;
}

// E := d(variable)' / d(core): of an inactive one through the prior's variables.
void NormalEquations::columns_of(const Graph& graph, VariableId id,
                                 Eigen::Ref<Eigen::MatrixXd> E) const {
  const Variable& v = graph.variables[id];
  if (v.is_active) {
    E.middleRows(v.core, v.dim()).diagonal().array() += 1.0;
    return;
  }
  graph.prior().active.add_transposed(graph.prior().inactive.gain({id}), E);
}

void NormalEquations::inactive_covariance(const Graph& graph, const GraphLandmark& l,
                                          JointMatrix& covariance) const {
  std::vector<VariableId> inactive;
  std::vector<int> at;
  for (const auto& [id, row] : {std::pair{l.anchor, kCameraDim}, std::pair{l.y, kCameraDim + 3}}) {
    if (graph.variables[id].is_active) continue;
    inactive.push_back(id);
    for (int k = 0; k < 3; ++k) at.push_back(row + k);
  }
  if (inactive.empty()) return;
  const Eigen::MatrixXd Sigma = graph.prior().inactive.covariance(inactive);
  for (std::size_t i = 0; i < at.size(); ++i) {
    for (std::size_t j = 0; j < at.size(); ++j) {
      covariance(at[i], at[j]) += Sigma(static_cast<int>(i), static_cast<int>(j));
    }
  }
}

// L^-1 E of every column that is asked for, where E = d(anchor or newest state)' / d(core). A
// column is zero above its first row, so that columns are sorted by it and solved for a few at a
// time.
void NormalEquations::prepare(const Graph& graph, std::span<const LandmarkId> landmarks) {
  compute_camera();
  asked_.clear();
  pieces_.clear();
  for (const LandmarkId id : landmarks) {
    if (!joints_[static_cast<std::size_t>(id)].known) ask(graph, id);
  }
  if (asked_.empty()) return;
  const Eigen::Index total = place_pieces();
  columns_.resize(core_dim_, total);
  (*columns_).setZero();
  for (const Asked& asked : asked_) fill_columns(graph, asked);
  solve_pieces();
  const Eigen::Index newest = core_dim_ - newest_core_;
  cross_.resize(total, kCameraDim);
  (*cross_).noalias() = (*columns_).bottomRows(newest).transpose() * *camera_columns_;
  for (const Asked& asked : asked_) fill_joint(asked);
}

void NormalEquations::ask(const Graph& graph, LandmarkId id) {
  const GraphLandmark& l = graph[id];
  const auto first_row = [&](VariableId v) {
    return graph.variables[v].is_active ? graph.variables[v].core : rates_dim_;
  };
  Asked asked{id, 0, static_cast<int>(pieces_.size())};
  const auto same = std::ranges::find(pieces_, l.anchor, &Piece::anchor);
  asked.anchor = static_cast<int>(same - pieces_.begin());
  if (same == pieces_.end()) {
    pieces_.push_back({l.anchor, first_row(l.anchor), 3, 0});
    ++asked.state;
  }
  int first = first_row(l.y);
  if (graph.variables[l.y].is_active) {
    const LandmarkBlock& block = blocks_[static_cast<std::size_t>(id)];
    if (!block.is_in_core()) {
      first = rates_dim_;
    } else if (block.dim() > 3) {  // one that has become free since has no w in the core
      first = std::min(first, first_row(l.w));
    }
  }
  pieces_.push_back({-1, first, state_dim(graph, id), 0});
  asked_.push_back(asked);
  joints_[static_cast<std::size_t>(id)].known = true;
}

// Side by side, those that begin in higher rows first.
Eigen::Index NormalEquations::place_pieces() {
  sorted_.clear();
  for (Piece& piece : pieces_) sorted_.push_back(&piece);
  std::ranges::sort(sorted_, {}, [](const Piece* p) { return std::pair(p->first, p); });
  Eigen::Index total = 0;
  for (Piece* piece : sorted_) {
    piece->column = total;
    total += piece->dim;
  }
  return total;
}

void NormalEquations::solve_pieces() {
  constexpr Eigen::Index kColumns = 24;  // at once
  auto C = *columns_;
  for (auto piece = sorted_.begin(); piece != sorted_.end();) {
    const int first = (*piece)->first;
    const Eigen::Index begin = (*piece)->column;
    Eigen::Index width = 0;
    while (piece != sorted_.end() && (width < kColumns || (*piece)->first == first)) {
      width += (*piece++)->dim;
    }
    const Eigen::Index rows = core_dim_ - first;
    solve_lower_in_place((*S_).bottomRightCorner(rows, rows), C.block(first, begin, rows, width));
  }
}

// E += d(newest state)' / d(core); `own`: what the core does not say of it, of an active one.
void NormalEquations::state_columns(const Graph& graph, LandmarkId id,
                                    Eigen::Ref<Eigen::MatrixXd> E, LandmarkMatrix& own) const {
  const VariableId y = graph[id].y;
  if (!graph.variables[y].is_active) return columns_of(graph, y, E);
  blocks_[static_cast<std::size_t>(id)].newest(E, own);
  if (!joints_[static_cast<std::size_t>(id)].is_new) return;
  auto rotation = E.middleRows<3>(camera_core_[1]);  // linearised where the last step has led
  rotation = (turn_.transpose() * rotation).eval();
}

// Of the anchor and the newest state; and what the core does not say of them.
void NormalEquations::fill_columns(const Graph& graph, const Asked& asked) {
  Joint& joint = joints_[static_cast<std::size_t>(asked.id)];
  const GraphLandmark& l = graph[asked.id];
  const Piece &anchor = piece(asked.anchor), &state = piece(asked.state);
  const int dim = state.dim;
  joint.covariance.setZero(kCameraDim + 3 + dim, kCameraDim + 3 + dim);
  auto of_anchor = (*columns_).middleCols(anchor.column, 3);
  of_anchor.setZero();  // another landmark's, too
  columns_of(graph, l.anchor, of_anchor);
  auto of_state = (*columns_).middleCols(state.column, dim);
  LandmarkMatrix own = LandmarkMatrix::Zero(dim, dim);
  state_columns(graph, asked.id, of_state, own);
  joint.covariance.bottomRightCorner(dim, dim) = own;
  inactive_covariance(graph, l, joint.covariance);
}

void NormalEquations::project(const Graph& graph, LandmarkId id,
                              const Eigen::Ref<const Eigen::MatrixXd>& H,
                              Eigen::Ref<Eigen::MatrixXd> C) const {
  C.setZero();
  C.middleRows<3>(camera_core_[0]) = H.middleCols<3>(kPosition).transpose();
  C.middleRows<3>(camera_core_[1]) =
      turn_.transpose().lazyProduct(H.middleCols<3>(kRotation).transpose());
  C.middleRows<6>(camera_core_[2]) = H.middleCols<6>(kVelocity).transpose();
  if (H.cols() == kCameraDim) return;
  const GraphLandmark& l = graph[id];
  const int dim = state_dim(graph, id);
  scratch_.resize(core_dim_, 3 + dim);
  auto E = *scratch_;
  E.setZero();
  columns_of(graph, l.anchor, E.leftCols<3>());
  LandmarkMatrix own;
  state_columns(graph, id, E.rightCols(dim), own);
  C += E.lazyProduct(H.rightCols(3 + dim).transpose());
}

void NormalEquations::fill_joint(const Asked& asked) {
  auto& P = joints_[static_cast<std::size_t>(asked.id)].covariance;
  constexpr int kAnchor = kCameraDim, kState = kCameraDim + 3;
  const Piece &anchor = piece(asked.anchor), &state = piece(asked.state);
  P.topLeftCorner<kCameraDim, kCameraDim>() = camera_covariance_;
  P.block<3, kCameraDim>(kAnchor, 0) = (*cross_).middleRows<3>(anchor.column);
  P.block(kState, 0, state.dim, kCameraDim) = (*cross_).middleRows(state.column, state.dim);
  const auto of = [&](const Piece& p, int first) {
    return (*columns_).block(first, p.column, core_dim_ - first, p.dim);
  };
  const int both = std::max(anchor.first, state.first);
  const auto a = of(anchor, anchor.first), x = of(state, state.first);
  P.block<3, 3>(kAnchor, kAnchor).noalias() += a.transpose() * a;
  P.block(kState, kAnchor, state.dim, 3).noalias() +=
      of(state, both).transpose() * of(anchor, both);
  P.bottomRightCorner(state.dim, state.dim).noalias() += x.transpose() * x;
  P.triangularView<Eigen::StrictlyUpper>() = P.transpose();
}

int NormalEquations::state_dim(const Graph& graph, LandmarkId id) const {
  return graph.variables[graph[id].y].is_active ? blocks_[static_cast<std::size_t>(id)].dim() : 3;
}

}  // namespace slammot
