#include "slammot/filters/joint_state.h"

#include <algorithm>

namespace slammot {

void JointState::move(const Eigen::VectorXd& dx) {
  camera = boxplus(camera, Vector12d(dx.head<kCameraDim>()));
  if (scene) scene->inverse_depth += dx(scene->block.offset);
  for (auto& [frame, anchor] : anchors) anchor.position += dx.segment<3>(anchor.block.offset);
  for (auto& [track, landmark] : landmarks) {
    landmark.y += dx.segment<3>(landmark.block.offset);
    if (landmark.is_free()) landmark.w += dx.segment<3>(landmark.w_block().offset);
  }
}

void JointState::correct(const Eigen::VectorXd& dx) {
  move(dx);
  covariance.transform({kRotation, 3}, right_jacobian_so3(dx.segment<3>(kRotation)));
}

void JointState::remove_blocks(std::vector<StateBlock> blocks) {
  std::sort(blocks.begin(), blocks.end(),
            [](const StateBlock& a, const StateBlock& b) { return a.offset < b.offset; });
  covariance.remove(blocks);
  for (auto& [frame, anchor] : anchors) {
    anchor.block.offset = shifted(anchor.block.offset, blocks);
  }
  for (auto& [track, landmark] : landmarks) {
    landmark.block.offset = shifted(landmark.block.offset, blocks);
  }
}

void JointState::remove_landmarks(const std::vector<int>& tracks) {
  std::vector<StateBlock> blocks;
  for (const int track : tracks) {
    const auto landmark = landmarks.find(track);
    blocks.push_back(landmark->second.block);
    const auto anchor = anchors.find(landmark->second.anchor);
    if (--anchor->second.landmarks == 0) {
      blocks.push_back(anchor->second.block);
      anchors.erase(anchor);
    }
    landmarks.erase(landmark);
  }
  remove_blocks(std::move(blocks));
}

void JointState::drop_motion(const std::vector<int>& tracks) {
  std::vector<StateBlock> blocks;
  for (const int track : tracks) {
    FilterLandmark& landmark = landmarks.at(track);
    blocks.push_back(landmark.w_block());
    landmark.w.setZero();
    landmark.block.dim = 3;
  }
  remove_blocks(std::move(blocks));
}

void JointState::free_motion(int track, double sigma) {
  FilterLandmark& landmark = landmarks.at(track);
  const StateBlock before = landmark.block;
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(6, 6);
  R.bottomRightCorner<3, 3>().diagonal().setConstant(sigma * sigma);
  landmark.block = covariance.append({{before, Eigen::MatrixXd::Identity(6, 3)}}, R);
  remove_blocks({before});
}

}  // namespace slammot
