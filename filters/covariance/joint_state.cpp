#include "filters/covariance/joint_state.h"

#include <algorithm>
#include <utility>

namespace slammot {

void JointState::move(Eigen::Ref<const Eigen::VectorXd> dx) {
  camera = boxplus(camera, Vector12d(dx.head<kCameraDim>()));
  if (scene) scene->inverse_depth += dx(scene->block.offset);
  for (FilterPose& clone : clones) {
    clone.position += dx.segment<3>(clone.block.offset);
    const Eigen::Vector3d turn = dx.segment<3>(clone.block.offset + kRotation);
    clone.orientation = clone.orientation * exp_so3(turn);
  }
  for (auto& [frame, anchor] : anchors) {
    anchor.position += dx.segment<3>(anchor.block.offset);
  }
  for (auto& [track, landmark] : landmarks) {
    landmark.y += dx.segment<3>(landmark.y_block.offset);
    if (landmark.is_free()) landmark.w += dx.segment(landmark.w_block.offset, landmark.w_block.dim);
    if (landmark.is_constrained()) {
      const StateBlock block = landmark.constrained_block;
      landmark.information_vector += dx.segment(block.offset, block.dim);
    }
  }
}

void JointState::correct(Eigen::Ref<const Eigen::VectorXd> dx) {
  move(dx);
  covariance.transform({{kRotation, 3}}, right_jacobian_so3(dx.segment<3>(kRotation)));
  for (const FilterPose& clone : clones) {
    const StateBlock rotation{clone.block.offset + kRotation, 3};
    covariance.transform({rotation}, right_jacobian_so3(dx.segment<3>(rotation.offset)));
  }
}

void JointState::clone_pose(FilterPose& clone) {
  clone.position = camera.position;
  clone.orientation = camera.orientation;
  Eigen::Matrix<double, 12, 12> copy = Eigen::Matrix<double, 12, 12>::Zero();
  copy.topRightCorner<6, 6>().setIdentity();
  copy.bottomRightCorner<6, 6>().setIdentity();
  covariance.transform({clone.block, kPose}, copy);
}

void JointState::follow(StateBlock from, StateBlock to) {
  const auto moved = [&](StateBlock& b) {
    if (b.offset == from.offset) b = to;
  };
  for (auto& [frame, anchor] : anchors) moved(anchor.block);
  for (auto& [track, landmark] : landmarks) {
    moved(landmark.y_block);
    if (landmark.is_free()) moved(landmark.w_block);
    if (landmark.is_constrained()) moved(landmark.constrained_block);
  }
}

bool JointState::is_last(int dim) const {
  const int end = covariance.size();
  const auto ends_it = [&](StateBlock b) { return b.end() == end && b.dim == dim; };
  return std::ranges::any_of(anchors, [&](const auto& a) { return ends_it(a.second.block); }) ||
         std::ranges::any_of(landmarks, [&](const auto& l) {
           return ends_it(l.second.y_block) || ends_it(l.second.w_block) ||
                  ends_it(l.second.constrained_block);
         });
}

// The last block moves into its place; where that has another size, all rows behind it move up.
void JointState::remove_block(StateBlock block) {
  if (is_last(block.dim)) {
    const auto moved = covariance.remove(block);
    if (moved) follow(*moved, block);
    return;
  }
  covariance.close_gap(block);  // camera and scene stand before all blocks and stay
  const auto moved_up = [&](StateBlock& b) {
    if (b.dim > 0 && b.offset > block.offset) b.offset -= block.dim;
  };
  for (auto& [frame, anchor] : anchors) moved_up(anchor.block);
  for (auto& [track, landmark] : landmarks) {
    moved_up(landmark.y_block);
    moved_up(landmark.w_block);
    moved_up(landmark.constrained_block);
  }
}

Eigen::MatrixXd JointState::marginal(const FilterLandmark& landmark) const {
  const StateBlock blocks[] = {anchors.at(landmark.anchor).block, landmark.y_block,
                               landmark.w_block};
  return marginal(blocks);
}

Eigen::MatrixXd JointState::marginal(std::span<const StateBlock> blocks) const {
  int dim = 0;
  for (const StateBlock& b : blocks) dim += b.dim;
  Eigen::MatrixXd P(dim, dim);
  int row = 0;
  for (const StateBlock& a : blocks) {
    int column = 0;
    for (const StateBlock& b : blocks) {
      P.block(row, column, a.dim, b.dim) = covariance.block(a, b);
      column += b.dim;
    }
    row += a.dim;
  }
  return P;
}

void JointState::remove_landmarks(std::span<const int> tracks) {
  for (const int track : tracks) {
    const auto landmark = landmarks.find(track);
    drop_motion(track);
    forget_motion(track);
    const StateBlock y = landmark->second.y_block;
    const auto anchor = anchors.find(landmark->second.anchor);
    landmarks.erase(landmark);
    remove_block(y);
    if (--anchor->second.landmarks > 0) continue;
    const StateBlock a = anchor->second.block;
    anchors.erase(anchor);
    remove_block(a);
  }
}

void JointState::drop_motion(int track) {
  FilterLandmark& landmark = landmarks.at(track);
  remove_motion(landmark.w, landmark.w_block);
}

void JointState::remove_motion(MotionVector& numbers, StateBlock& block) {
  if (block.dim == 0) return;
  numbers.resize(0);
  remove_block(std::exchange(block, {}));
}

void JointState::free_motion(int track, const MotionVector& sigmas) {
  FilterLandmark& landmark = landmarks.at(track);
  landmark.w.setZero(sigmas.size());
  landmark.w_block = covariance.append({}, sigmas.cwiseAbs2().asDiagonal().toDenseMatrix());
}

}  // namespace slammot
