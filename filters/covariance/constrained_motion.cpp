// A label that can be undone. What w = 0, used as a measurement, does to a Gaussian is a sweep of
// its covariance on the rows of w:
//
//   (P_xx  P_xw)    (P_xx - P_xw P_ww^-1 P_wx   P_xw P_ww^-1)
//   (P_wx  P_ww) -> (P_ww^-1 P_wx                   -P_ww^-1)
//
// The corner above is the covariance given w = 0. With the rest kept, x = x(0) + Phi w for any
// other w, Phi = P_xw P_ww^-1, and w has the information J = P_ww^-1 and the information vector j =
// J w. A measurement changes Phi to (I - K H) Phi, J by Phi'H' S^-1 H Phi and j by Phi'H' S^-1 nu:
// this is what P - P H' S^-1 H P and dx = P H' S^-1 nu say of these rows, so that they follow an
// update as all others do. y stays that of the time at which the landmark came to rest, so that its
// pixel at a later time has the Jacobian H Phi + J_y F_yw(t) with respect to w (update.cpp). The
// reverse sweep undoes the label, and all that it did since. Willsky
// and Jones (1976) find jumps in this way.
#include <Eigen/Cholesky>

#include "filters/covariance/joint_state.h"

namespace slammot {

void JointState::constrain_motion(int track, const Eigen::MatrixXd& sensitivity,
                                  const Eigen::MatrixXd& information,
                                  const Eigen::VectorXd& vector) {
  FilterLandmark& landmark = landmarks.at(track);
  const StateBlock w = landmark.w_block;
  covariance.assign(w, sensitivity, -information);
  landmark.information_vector = vector;
  landmark.constrained_block = w;
  landmark.w.resize(0);
  landmark.w_block = {};
}

std::optional<JointState::Motion> JointState::constrained_motion(int track) const {
  const FilterLandmark& landmark = landmarks.at(track);
  const MotionMatrix J = -covariance.block(landmark.constrained_block, landmark.constrained_block);
  const Eigen::LLT<MotionMatrix> llt(J);
  if (llt.info() != Eigen::Success) return std::nullopt;
  return Motion{llt.solve(landmark.information_vector),
                llt.solve(MotionMatrix::Identity(J.rows(), J.cols()))};
}

Eigen::VectorXd JointState::release_motion(int track, const Motion& motion,
                                           const Eigen::MatrixXd& F_yw) {
  FilterLandmark& landmark = landmarks.at(track);
  const StateBlock w = landmark.constrained_block;
  Eigen::MatrixXd sensitivity(covariance.size(), w.dim);
  covariance.columns(w, sensitivity);
  sensitivity.middleRows(w.offset, w.dim).setZero();
  sensitivity.middleRows<3>(landmark.y_block.offset) += F_yw;  // dy at this time, not at rest
  const Eigen::MatrixXd P_xw = sensitivity * motion.covariance;
  covariance.add_product(sensitivity.transpose().eval(), P_xw.transpose().eval());
  covariance.assign(w, P_xw, motion.covariance);
  landmark.w.setZero(w.dim);
  landmark.w_block = w;
  landmark.information_vector.resize(0);
  landmark.constrained_block = {};
  Eigen::VectorXd dx = sensitivity * motion.mean;
  dx.segment(w.offset, w.dim) = motion.mean;
  return dx;
}

void JointState::forget_motion(int track) {
  FilterLandmark& landmark = landmarks.at(track);
  remove_motion(landmark.information_vector, landmark.constrained_block);
}

}  // namespace slammot
