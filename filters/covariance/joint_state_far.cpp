// What of the joint state is near and what is far.
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

void JointState::rest(const std::vector<int>& tracks) {
  correct_far();
  std::vector<StateBlock*> kept, resting;
  std::set<int> used;  // anchors
  for (auto& [track, landmark] : landmarks) {
    if (landmark.is_far()) continue;
    const bool rests = std::binary_search(tracks.begin(), tracks.end(), track);
    (rests ? resting : kept).push_back(&landmark.y_block);
    if (rests) continue;
    if (landmark.is_free()) kept.push_back(&landmark.w_block);
    used.insert(landmark.anchor);
  }
  for (auto& [frame, anchor] : anchors) {
    if (!anchor.block.far) (used.contains(frame) ? kept : resting).push_back(&anchor.block);
  }
  std::ranges::sort(kept, {}, [](const StateBlock* b) { return b->offset; });  // newest last
  const int first = scene ? scene->block.end() : kCamera.end();
  int next_far = far.size();
  far.fold(covariance, rows_of(first, kept), rows_of(0, resting), first);
  int next_near = far.adjoint().end();
  for (StateBlock* b : kept) *b = {std::exchange(next_near, next_near + b->dim), b->dim};
  for (StateBlock* b : resting) *b = {std::exchange(next_far, next_far + b->dim), b->dim, true};
}

void JointState::bring_back(int track) {
  FilterLandmark& landmark = landmarks.at(track);
  if (!landmark.is_far()) return;
  correct_far();
  FilterAnchor& anchor = anchors.at(landmark.anchor);
  if (anchor.block.far) anchor.block = bring_back(anchor.block);
  landmark.y_block = bring_back(landmark.y_block);
}

// The block after the adjoint makes room for the one that it grows by.
StateBlock JointState::bring_back(StateBlock block) {
  const StateBlock room{far.adjoint().end(), block.dim};
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity(), zero = Eigen::Matrix3d::Zero();
  if (room.offset == covariance.size()) {
    covariance.append({}, zero);
  } else {
    follow(room, covariance.append({{room, I}}, zero));
  }
  const StateBlock back = far.bring_back(covariance, block);
  const auto moved = far.remove(block);
  if (moved) follow(*moved, block);
  return back;
}

void JointState::correct_far() {
  if (far.empty() || !far.has_correction()) return;
  const Eigen::VectorXd dx = far.take_correction();
  for (auto& [frame, anchor] : anchors) {
    if (anchor.block.far) anchor.position += dx.segment<3>(anchor.block.offset);
  }
  for (auto& [track, landmark] : landmarks) {
    if (landmark.is_far()) landmark.y += dx.segment<3>(landmark.y_block.offset);
  }
}

Eigen::MatrixXd JointState::marginal(const FilterLandmark& landmark) const {
  const StateBlock blocks[] = {anchors.at(landmark.anchor).block, landmark.y_block,
                               landmark.w_block};
  const int dim = 3 + landmark.dim();
  Eigen::MatrixXd P(dim, dim);
  for (int j = 0, column = 0; j < 3; column += blocks[j++].dim) {
    const StateBlock b = blocks[j];
    Eigen::MatrixXd far_columns;
    if (b.far) far_columns = far.columns(covariance, b);
    for (int i = 0, row = 0; i < 3; row += blocks[i++].dim) {
      const StateBlock a = blocks[i];
      auto P_ab = P.block(row, column, a.dim, b.dim);
      if (!a.far && !b.far) P_ab = covariance.block(a, b);
      if (!a.far && b.far) P_ab = far_columns.middleRows(a.offset, a.dim);
      if (a.far && b.far) P_ab = far.block(a, b, far_columns);
    }
  }
  if (landmark.is_far()) P.triangularView<Eigen::StrictlyLower>() = P.transpose();
  return P;
}

}  // namespace slammot
