#include "filters/covariance/joint_state.h"

namespace slammot {

void JointState::move(Eigen::Ref<const Eigen::VectorXd> dx) {
  camera = boxplus(camera, Vector12d(dx.head<kCameraDim>()));
  if (scene) scene->inverse_depth += dx(scene->block.offset);
  for (auto& [frame, anchor] : anchors) {
    if (!anchor.block.far) anchor.position += dx.segment<3>(anchor.block.offset);
  }
  for (auto& [track, landmark] : landmarks) {
    if (landmark.is_far()) continue;
    landmark.y += dx.segment<3>(landmark.y_block.offset);
    if (landmark.is_free()) landmark.w += dx.segment<3>(landmark.w_block.offset);
  }
  if (!far.empty()) far.correct(dx.segment(far.adjoint().offset, far.adjoint().dim));
}

void JointState::correct(Eigen::Ref<const Eigen::VectorXd> dx) {
  move(dx);
  covariance.transform({{kRotation, 3}}, right_jacobian_so3(dx.segment<3>(kRotation)));
}

void JointState::follow(StateBlock from, StateBlock to) {
  const auto moved = [&](StateBlock& b) {
    if (b.offset == from.offset && b.far == from.far) b = to;
  };
  for (auto& [frame, anchor] : anchors) moved(anchor.block);
  for (auto& [track, landmark] : landmarks) {
    moved(landmark.y_block);
    if (landmark.is_free()) moved(landmark.w_block);
  }
}

// Another block may move into its place.
void JointState::remove_block(StateBlock block) {
  const auto moved = block.far ? far.remove(block) : covariance.remove(block);
  if (moved) follow(*moved, block);
}

void JointState::remove_landmarks(std::span<const int> tracks) {
  for (const int track : tracks) {
    const auto landmark = landmarks.find(track);
    drop_motion(track);
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
  if (!landmark.is_free()) return;
  const StateBlock w = landmark.w_block;
  landmark.w.setZero();
  landmark.w_block = {};
  remove_block(w);
}

void JointState::free_motion(int track, double sigma) {
  landmarks.at(track).w_block = covariance.append({}, sigma * sigma * Eigen::Matrix3d::Identity());
}

}  // namespace slammot
