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

// Columns of landmarks that are in the core from the newest camera's rows on come last, and are
// solved for there only.
void NormalEquations::prepare(const Graph& graph, std::span<const LandmarkId> landmarks) {
  compute_camera();
  asked_.clear();
  for (const LandmarkId id : landmarks) {
    if (!joints_[static_cast<std::size_t>(id)].known)
      asked_.push_back({id, lies_low(graph, id), 0});
  }
  if (asked_.empty()) return;
  std::ranges::stable_sort(asked_, {}, &Asked::low);
  Eigen::Index high = 0, total = 0;
  for (Asked& asked : asked_) {
    asked.column = total;
    total += 3 + state_dim(graph, asked.id);
    if (!asked.low) high = total;
    joints_[static_cast<std::size_t>(asked.id)].known = true;
  }
  columns_.resize(core_dim_, total);
  auto C = *columns_;
  C.setZero();
  for (const Asked& asked : asked_)
    fill_columns(graph, asked.id, C.middleCols(asked.column, 3 + state_dim(graph, asked.id)));
  const Eigen::Index rest = core_dim_ - rates_dim_, newest = core_dim_ - newest_core_;
  solve_lower_in_place((*S_).bottomRightCorner(rest, rest), C.bottomLeftCorner(rest, high));
  solve_lower_in_place((*S_).bottomRightCorner(newest, newest),
                       C.bottomRightCorner(newest, total - high));
  cross_.resize(total, kCameraDim);
  (*cross_).noalias() = C.bottomRows(newest).transpose() * *camera_columns_;
  for (const Asked& asked : asked_) {
    auto& P = joints_[static_cast<std::size_t>(asked.id)].covariance;
    const Eigen::Index dim = 3 + state_dim(graph, asked.id);
    const auto own = C.middleCols(asked.column, dim).bottomRows(asked.low ? newest : rest);
    P.topLeftCorner<kCameraDim, kCameraDim>() = camera_covariance_;
    P.bottomLeftCorner(dim, kCameraDim) = (*cross_).middleRows(asked.column, dim);
    P.topRightCorner(kCameraDim, dim) = P.bottomLeftCorner(dim, kCameraDim).transpose();
    P.bottomRightCorner(dim, dim).noalias() += own.transpose() * own;
  }
}

bool NormalEquations::lies_low(const Graph& graph, LandmarkId id) const {
  const GraphLandmark& l = graph[id];
  const Variable &y = graph.variables[l.y], &anchor = graph.variables[l.anchor];
  return y.is_active && anchor.is_active && anchor.core >= newest_core_ && !y.is_private &&
         y.core >= newest_core_ && blocks_[static_cast<std::size_t>(id)].is_in_core();
}

// Of the anchor and the newest state; and what the core does not say of them.
void NormalEquations::fill_columns(const Graph& graph, LandmarkId id,
                                   Eigen::Ref<Eigen::MatrixXd> C) {
  Joint& joint = joints_[static_cast<std::size_t>(id)];
  const GraphLandmark& l = graph[id];
  const int dim = state_dim(graph, id);
  joint.covariance.setZero(kCameraDim + 3 + dim, kCameraDim + 3 + dim);
  columns_of(graph, l.anchor, C.leftCols<3>());
  auto of_state = C.rightCols(dim);
  if (graph.variables[l.y].is_active) {
    LandmarkMatrix own;
    blocks_[static_cast<std::size_t>(id)].newest(of_state, own);
    joint.covariance.bottomRightCorner(dim, dim) = own;
    if (joint.is_new) {  // linearised where the last step has led
      auto rotation = of_state.middleRows<3>(camera_core_[1]);
      rotation = (turn_.transpose() * rotation).eval();
    }
  } else {
    columns_of(graph, l.y, of_state);
  }
  inactive_covariance(graph, l, joint.covariance);
}

int NormalEquations::state_dim(const Graph& graph, LandmarkId id) const {
  return graph.variables[graph[id].y].is_active ? blocks_[static_cast<std::size_t>(id)].dim() : 3;
}

}  // namespace slammot
