// Marginals from a factorisation of the normal equations.
#include <algorithm>
#include <cassert>

#include "models/lapack.h"
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
  graph.prior().active.add_transposed(
      graph.prior().inactive.gain({id}, graph.prior().active.linear_chart()), E);
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
// column is zero above its first row, so that new ones are sorted by it and solved for a few at a
// time. All are kept until the next factorisation: an anchor is solved for once, and what pixels
// share is read from them (project).
void NormalEquations::prepare(const Graph& graph, std::span<const LandmarkId> landmarks) {
  compute_camera();
  asked_.clear();
  const std::size_t first = pieces_.size();
  for (const LandmarkId id : landmarks) {
    if (!joints_[static_cast<std::size_t>(id)].known) ask(graph, id);
  }
  if (asked_.empty()) return;
  const Eigen::Index begin = columns_.cols();
  place_pieces(first);
  const Eigen::Index total = columns_.cols() - begin;
  (*columns_).rightCols(total).setZero();
  for (const Piece* p : sorted_) {
    if (p->anchor >= 0) columns_of(graph, p->anchor, (*columns_).middleCols(p->column, p->dim));
  }
  for (const LandmarkId id : asked_) fill_columns(graph, id);
  solve_pieces();
  const Eigen::Index newest = core_dim_ - newest_core_;
  cross_.add_columns(total);
  (*cross_).rightCols(total).noalias() =
      (*camera_columns_).transpose() * (*columns_).bottomRightCorner(newest, total);
  for (const LandmarkId id : asked_) fill_joint(id);
}

void NormalEquations::ask(const Graph& graph, LandmarkId id) {
  const GraphLandmark& l = graph[id];
  const auto first_row = [&](VariableId v) {
    return graph.variables[v].is_active ? graph.variables[v].core : rates_dim_;
  };
  Joint& joint = joints_[static_cast<std::size_t>(id)];
  const auto same = std::ranges::find(pieces_, l.anchor, &Piece::anchor);
  joint.anchor = static_cast<int>(same - pieces_.begin());
  if (same == pieces_.end()) pieces_.push_back({l.anchor, first_row(l.anchor), 3, 0});
  int first = first_row(l.y);
  if (graph.variables[l.y].is_active) {
    const LandmarkBlock& block = blocks_[static_cast<std::size_t>(id)];
    if (!block.has_no_private_state()) {
      first = rates_dim_;
    } else if (block.dim() > 3) {  // one that has become free since has no w in the core
      first = std::min(first, first_row(l.w));
    }
  }
  joint.state = static_cast<int>(pieces_.size());
  pieces_.push_back({-1, first, state_dim(graph, id), 0});
  joint.known = true;
  asked_.push_back(id);
}

// From the `first` piece on, side by side, those that begin in higher rows first.
void NormalEquations::place_pieces(std::size_t first) {
  sorted_.clear();
  for (std::size_t i = first; i < pieces_.size(); ++i) sorted_.push_back(&pieces_[i]);
  std::ranges::sort(sorted_, {}, [](const Piece* p) { return std::pair(p->first, p); });
  for (Piece* piece : sorted_) {
    piece->column = columns_.cols();
    columns_.add_columns(piece->dim);
  }
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

// Of the newest state; and what the core does not say of it and of the anchor.
void NormalEquations::fill_columns(const Graph& graph, LandmarkId id) {
  Joint& joint = joints_[static_cast<std::size_t>(id)];
  const Piece& state = piece(joint.state);
  const int dim = state.dim;
  joint.covariance.setZero(kCameraDim + 3 + dim, kCameraDim + 3 + dim);
  LandmarkMatrix own = LandmarkMatrix::Zero(dim, dim);
  state_columns(graph, id, (*columns_).middleCols(state.column, dim), own);
  joint.covariance.bottomRightCorner(dim, dim) = own;
  inactive_covariance(graph, graph[id], joint.covariance);
}

void NormalEquations::project(LandmarkId id, const Eigen::Ref<const Eigen::MatrixXd>& H,
                              Eigen::Ref<Eigen::MatrixXd> C) const {
  assert(camera_columns_.cols() > 0);
  C.topRows(newest_core_).setZero();
  C.bottomRows(core_dim_ - newest_core_) =
      (*camera_columns_).lazyProduct(H.leftCols<kCameraDim>().transpose());
  if (H.cols() == kCameraDim) return;
  const auto add = [&](const Piece& p, int column) {
    const int rows = core_dim_ - p.first;
    C.bottomRows(rows) += (*columns_)
                              .block(p.first, p.column, rows, p.dim)
                              .lazyProduct(H.middleCols(column, p.dim).transpose());
  };
  const Joint& joint = joints_[static_cast<std::size_t>(id)];
  assert(joint.known);
  add(piece(joint.anchor), kCameraDim);
  add(piece(joint.state), kCameraDim + 3);
}

void NormalEquations::whiten(Eigen::Ref<Eigen::MatrixXd> C) const { solve_lower_in_place(*S_, C); }

void NormalEquations::fill_joint(LandmarkId id) {
  Joint& joint = joints_[static_cast<std::size_t>(id)];
  JointMatrix& P = joint.covariance;
  constexpr int kAnchor = kCameraDim, kState = kCameraDim + 3;
  const Piece &anchor = piece(joint.anchor), &state = piece(joint.state);
  P.topLeftCorner<kCameraDim, kCameraDim>() = camera_covariance_;
  P.block<3, kCameraDim>(kAnchor, 0) = (*cross_).middleCols<3>(anchor.column).transpose();
  P.block(kState, 0, state.dim, kCameraDim) =
      (*cross_).middleCols(state.column, state.dim).transpose();
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
