// What of the joint state is active and what is passive.
#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "filters/covariance/joint_state.h"

namespace slammot {

namespace {

// The first `first` rows, and those of the blocks.
std::vector<int> rows_of(int first, const std::vector<StateBlock*>& blocks) {
  std::vector<int> rows(static_cast<std::size_t>(first));
  std::iota(rows.begin(), rows.end(), 0);
  for (const StateBlock* b : blocks) {
    for (int k = 0; k < b->dim; ++k) rows.push_back(b->offset + k);
  }
  return rows;
}

}  // namespace

void JointState::deactivate(const std::vector<int>& tracks) {
  correct_passive();
  std::vector<StateBlock*> kept, deactivated;
  std::set<int> used;  // anchors
  for (auto& [track, landmark] : landmarks) {
    if (landmark.is_passive()) continue;
    const bool is_idle = std::binary_search(tracks.begin(), tracks.end(), track);
    (is_idle ? deactivated : kept).push_back(&landmark.y_block);
    if (is_idle) continue;
    if (landmark.is_free()) kept.push_back(&landmark.w_block);
    if (landmark.is_held()) kept.push_back(&landmark.held_block);
    used.insert(landmark.anchor);
  }
  for (auto& [frame, anchor] : anchors) {
    if (!anchor.block.passive) (used.contains(frame) ? kept : deactivated).push_back(&anchor.block);
  }
  std::ranges::sort(kept, {}, [](const StateBlock* b) { return b->offset; });  // newest last
  const int first = scene ? scene->block.end() : kCamera.end();
  int next_passive = passive.size();
  passive.synchronise(covariance, rows_of(first, kept), rows_of(0, deactivated), first);
  int next_active = passive.adjoint().end();
  for (StateBlock* b : kept) *b = {std::exchange(next_active, next_active + b->dim), b->dim};
  for (StateBlock* b : deactivated)
    *b = {std::exchange(next_passive, next_passive + b->dim), b->dim, true};
}

void JointState::reactivate(int track) {
  FilterLandmark& landmark = landmarks.at(track);
  if (!landmark.is_passive()) return;
  correct_passive();
  FilterAnchor& anchor = anchors.at(landmark.anchor);
  if (anchor.block.passive) anchor.block = reactivate(anchor.block);
  landmark.y_block = reactivate(landmark.y_block);
}

// The block after the adjoint makes room for the one that it grows by.
StateBlock JointState::reactivate(StateBlock block) {
  const StateBlock room{passive.adjoint().end(), block.dim};
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity(), zero = Eigen::Matrix3d::Zero();
  if (room.offset == covariance.size()) {
    covariance.append({}, zero);
  } else {
    follow(room, covariance.append({{room, I}}, zero));
  }
  const StateBlock back = passive.reactivate(covariance, block);
  const auto moved = passive.remove(block);
  if (moved) follow(*moved, block);
  return back;
}

void JointState::correct_passive() {
  if (passive.empty() || !passive.has_correction()) return;
  const Eigen::VectorXd dx = passive.take_correction();
  for (auto& [frame, anchor] : anchors) {
    if (anchor.block.passive) anchor.position += dx.segment<3>(anchor.block.offset);
  }
  for (auto& [track, landmark] : landmarks) {
    if (landmark.is_passive()) landmark.y += dx.segment<3>(landmark.y_block.offset);
  }
}

Eigen::MatrixXd JointState::marginal(const FilterLandmark& landmark) const {
  const StateBlock blocks[] = {anchors.at(landmark.anchor).block, landmark.y_block,
                               landmark.w_block};
  return marginal(std::span(blocks).first(landmark.is_free() ? 3 : 2));
}

Eigen::MatrixXd JointState::marginal(std::span<const StateBlock> blocks) const {
  int dim = 0;
  for (const StateBlock b : blocks) dim += b.dim;
  Eigen::MatrixXd P(dim, dim);
  int column = 0;
  for (const StateBlock b : blocks) {
    Eigen::MatrixXd passive_columns;
    if (b.passive) passive_columns = passive.columns(covariance, b);
    int row = 0;
    for (const StateBlock a : blocks) {
      auto P_ab = P.block(row, column, a.dim, b.dim);
      if (!a.passive && !b.passive) P_ab = covariance.block(a, b);
      if (!a.passive && b.passive) P_ab = passive_columns.middleRows(a.offset, a.dim);
      if (a.passive && b.passive) P_ab = passive.block(a, b, passive_columns);
      row += a.dim;
    }
    column += b.dim;
  }
  if (blocks.back().passive) P.triangularView<Eigen::StrictlyLower>() = P.transpose();
  return P;
}

}  // namespace slammot
