// A static landmark's motion that is remembered (filters/covariance/held_motion.cpp).
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "filters/covariance/joint_state.h"

namespace slammot {
namespace {

constexpr int kTrack = 7;
constexpr StateBlock kAnchor{12, 3}, kY{15, 3}, kW{18, 3};
constexpr int kDim = 21;

// A camera, an anchor and a free landmark, of any covariance.
JointState any_state() {
  JointState state;
  state.covariance.append({}, JointCovariance::Block::Identity(12, 12));
  for (int i = 0; i < 3; ++i) state.covariance.append({}, Eigen::Matrix3d::Identity());
  std::srand(1);
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(kDim, kDim);
  state.covariance.assign(A * A.transpose() + Eigen::MatrixXd::Identity(kDim, kDim));
  state.anchors[0] = {Eigen::Vector3d::Zero(), kAnchor, 1};
  FilterLandmark& landmark = state.landmarks[kTrack];
  landmark.y = Eigen::Vector3d(0.1, 0.2, 0.3);
  landmark.w = Eigen::Vector3d(0.5, -0.4, 0.3);
  landmark.y_block = kY;
  landmark.w_block = kW;
  return state;
}

// The rotation's tangent space does not turn here, so that all is linear.
void measure(JointState& state, const Eigen::MatrixXd& H, const Eigen::VectorXd& nu) {
  const Eigen::MatrixXd P_Ht = state.covariance.dense() * H.transpose();
  const Eigen::LLT<Eigen::MatrixXd> S(H * P_Ht + Eigen::MatrixXd::Identity(H.rows(), H.rows()));
  Eigen::MatrixXd W = P_Ht;
  S.matrixU().solveInPlace<Eigen::OnTheRight>(W);
  state.covariance.subtract_outer(W);
  state.move(P_Ht * S.solve(nu));
}

// A step of the time, in which a free landmark moves with w; `F` is dy/dw.
void predict(JointState& state, const Eigen::Matrix3d& F) {
  FilterLandmark& landmark = state.landmarks.at(kTrack);
  if (landmark.is_held()) {
    state.covariance.add(landmark.y_block, landmark.held_block, F);
    return;
  }
  landmark.y += F * landmark.w;
  Eigen::MatrixXd of_landmark = Eigen::MatrixXd::Identity(6, 6);
  of_landmark.topRightCorner<3, 3>() = F;
  state.covariance.propagate({landmark.y_block, landmark.w_block}, of_landmark,
                             Eigen::MatrixXd::Zero(6, 6));
}

void hold(JointState& state) {
  const Eigen::MatrixXd P = state.covariance.dense();
  const Eigen::Matrix3d J = P.block<3, 3>(kW.offset, kW.offset).inverse();
  const Eigen::MatrixXd P_w = P.middleCols<3>(kW.offset);
  const Eigen::Vector3d w = state.landmarks.at(kTrack).w;
  Eigen::VectorXd dx = -P_w * J * w;
  dx.segment<3>(kW.offset).setZero();
  state.covariance.assign(P - P_w * J * P_w.transpose());
  state.hold_motion(kTrack, P_w * J, J, J * w);
  state.move(dx);
}

void release(JointState& state) {
  const auto motion = state.held_motion(kTrack);
  ASSERT_TRUE(motion);
  state.move(state.release_motion(kTrack, *motion));
}

TEST(HeldMotion, ReleasedAfterStepsAndMeasurementsIsAsIfNeverHeld) {
  JointState free = any_state(), held = any_state();
  Eigen::MatrixXd H = Eigen::MatrixXd::Random(4, kDim);
  H.rightCols<3>().setZero();  // no pixel sees w
  H.middleCols<3>(kRotation).setZero();
  hold(held);
  EXPECT_FALSE(held.landmarks.at(kTrack).is_free());
  for (int k = 0; k < 3; ++k) {
    // The innovation of the held state is that at its own estimate.
    const Eigen::VectorXd z = Eigen::VectorXd::Random(4);
    const auto innovation = [&](const JointState& state) -> Eigen::VectorXd {
      Eigen::VectorXd x = Eigen::VectorXd::Zero(kDim);
      x.segment<3>(kPosition) = state.camera.position;
      x.segment<3>(kVelocity) = state.camera.velocity;
      x.segment<3>(kAnchor.offset) = state.anchors.at(0).position;
      x.segment<3>(kY.offset) = state.landmarks.at(kTrack).y;
      return z - H * x;
    };
    H.middleCols<3>(kAngularVelocity).setZero();
    const Eigen::Matrix3d F = Eigen::Matrix3d::Random();
    predict(free, F);
    predict(held, F);
    measure(free, H, innovation(free));
    measure(held, H, innovation(held));
  }
  EXPECT_GT((held.covariance.dense() - free.covariance.dense()).norm(), 1.0);
  release(held);
  const FilterLandmark &a = held.landmarks.at(kTrack), &b = free.landmarks.at(kTrack);
  EXPECT_TRUE(a.is_free());
  EXPECT_LT((held.covariance.dense() - free.covariance.dense()).norm(), 1e-10);
  EXPECT_LT((a.w - b.w).norm(), 1e-10);
  EXPECT_LT((a.y - b.y).norm(), 1e-10);
  EXPECT_LT((held.camera.position - free.camera.position).norm(), 1e-10);
}

TEST(HeldMotion, ForgottenLeavesTheRestAsItIs) {
  JointState state = any_state();
  hold(state);
  const Eigen::MatrixXd before = state.covariance.dense().topLeftCorner(kW.offset, kW.offset);
  state.forget_motion(kTrack);
  EXPECT_EQ(state.covariance.size(), kW.offset);
  EXPECT_EQ(state.covariance.dense(), before);
  EXPECT_FALSE(state.landmarks.at(kTrack).is_held());
}

}  // namespace
}  // namespace slammot
