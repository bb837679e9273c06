// A camera and four landmarks, for tests of the EKF's joint state.
#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "filters/update.h"

namespace slammot {

inline Camera pinhole() { return {640, 480, 385.0, 385.0, 319.5, 239.5, PinholeLens{}}; }

// The landmarks are born with the camera; `anchors` of them, shared or one for each.
inline JointState scene(int anchors) {
  JointState state;
  Vector12d sigma;
  sigma << Eigen::Vector3d::Constant(0.05), Eigen::Vector3d::Constant(0.01),
      Eigen::Vector3d::Constant(0.3), Eigen::Vector3d::Constant(0.1);
  state.covariance.append({}, sigma.cwiseAbs2().asDiagonal().toDenseMatrix());
  for (int i = 0; i < anchors; ++i) {
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    const StateBlock block =
        state.covariance.append({{{kPosition, 3}, I}}, Eigen::Matrix3d::Zero());
    state.anchors[i] = {state.camera.position, block, 0};
  }
  for (int i = 0; i < 4; ++i) {
    FilterLandmark& l = state.landmarks[i];
    l.anchor = i % anchors;
    l.y = {0.2 * i - 0.3, 0.1 * (i % 2), 0.2};
    l.y_block =
        state.covariance.append({}, Eigen::Vector3d(1e-5, 1e-5, 1e-3).asDiagonal().toDenseMatrix());
    ++state.anchors.at(l.anchor).landmarks;
  }
  return state;
}

// Jacobians at the estimate, and nothing stated or kept beside the thesis's.
inline Devices plain(const LandmarkFunctions& functions) {
  return {functions, Linearisation(FilterLinearisation::kStandard, functions, nullptr), {}};
}

// Of any size.
inline JointCovariance joint_of(const Eigen::MatrixXd& P) {
  JointCovariance joint;
  std::vector<StateBlock> before;
  const auto size = static_cast<int>(P.rows());
  for (int at = 0; at < size; at += JointCovariance::kLargestBlock) {
    const int dim = std::min(size - at, JointCovariance::kLargestBlock);
    const StateBlock b = joint.append({}, P.block(at, at, dim, dim));
    for (const StateBlock& a : before) joint.add(a, b, P.block(a.offset, at, a.dim, dim));
    before.push_back(b);
  }
  return joint;
}

// Of all landmarks, with 2 px of noise.
inline std::vector<Observation> pixels_of(const JointState& state, const PointFunctions& point,
                                          unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<Observation> matches;
  for (const auto& [track, l] : state.landmarks) {
    const auto z = observe(pinhole(), point, state.camera.position, state.camera.orientation,
                           state.anchors.at(l.anchor).position, l.y);
    matches.push_back({track, z->pixel + 2.0 * Eigen::Vector2d(normal(engine), normal(engine))});
  }
  return matches;
}

// The camera moves for 0.1 s, and is corrected.
inline void step(JointState& state, Devices& devices, const std::vector<Observation>& matches) {
  MotionNoise noise{2.0, 1.0};
  const double dt = 0.1;
  state.covariance.propagate({JointState::kCamera}, predict_jacobian(state.camera, dt),
                             camera_noise(noise, state.camera, dt));
  state.camera = predict(state.camera, dt);
  Innovation z;
  linearise(state, devices, pinhole(), matches, z);
  update(state, devices, pinhole(), 1.0, 1, z);
}

}  // namespace slammot
