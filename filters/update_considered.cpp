#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "filters/update.h"

namespace slammot {

namespace {

void update_considered(JointState& state, Devices& devices, const Rig& rig,
                       const Observation& match, double pixel_sigma, Innovation& memory) {
  constexpr int kMost = JointCovariance::kLargestBlock;
  using Gain = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::ColMajor, kMost, 2>;
  using Own = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMost, 1>;
  linearise(state, devices, rig, {&match, 1}, memory);
  if (memory.rows() == 0) return;  // the others have moved it out of view
  fill_HPHt(state, memory, memory.S);
  (*memory.S).diagonal().array() += match.variance(pixel_sigma);
  const Eigen::Matrix2d S = Eigen::Matrix2d(*memory.S).selfadjointView<Eigen::Lower>();
  if (S.llt().info() != Eigen::Success) {
    throw Diverged("the innovation covariance is not positive definite");
  }
  FilterLandmark& landmark = state.landmarks.at(match.track);
  const StateBlock y = landmark.y_block, w = landmark.w_block;
  const auto P_Ht = *memory.P_Ht;
  Gain K(landmark.dim(), 2);
  K << P_Ht.middleRows(y.offset, y.dim), P_Ht.middleRows(w.offset, w.dim);
  K *= S.inverse();
  const Own dx = K * memory.nu.front();
  if (!dx.allFinite()) throw Diverged("the correction of the state is not finite");
  memory.columns.resize(P_Ht.rows(), K.rows());
  auto C = *memory.columns;
  C = P_Ht.lazyProduct(K.transpose());
  JointCovariance::Block D = K * S * K.transpose();
  const auto before =
      devices.gauge ? devices.gauge->directions(landmark) : GaugeError::Directions();
  landmark.y += dx.head<3>();
  landmark.w += dx.tail(w.dim);
  if (devices.gauge) devices.gauge->moved_alone(landmark, before, C, D);
  state.covariance.subtract_alone({y, w}, C, D);
}

}  // namespace

void update_considered(JointState& state, Devices& devices, const Rig& rig,
                       std::span<const Observation> matches, double pixel_sigma,
                       Innovation& memory) {
  if (matches.empty()) return;
  if (devices.gauge) devices.gauge->prepare(state);
  for (const Observation& match : matches) {
    update_considered(state, devices, rig, match, pixel_sigma, memory);
  }
}

}  // namespace slammot
