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

#include "estimation/estimator.h"
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

Eigen::VectorXd JointState::release_motions(std::span<const Released> released) {
  const Eigen::Index n = landmarks.at(released.front().track).constrained_block.dim;
  const Eigen::Index m = n * std::ssize(released);
  const auto block = [&](std::size_t i) {
    return landmarks.at(released[i].track).constrained_block;
  };
  Eigen::MatrixXd J(m, m), sensitivity(covariance.size(), m);
  Eigen::VectorXd j(m);
  for (std::size_t i = 0; i < released.size(); ++i) {
    const auto at = n * static_cast<Eigen::Index>(i);
    for (std::size_t k = 0; k < released.size(); ++k) {
      J.block(at, n * static_cast<Eigen::Index>(k), n, n) = -covariance.block(block(i), block(k));
    }
    j.segment(at, n) = landmarks.at(released[i].track).information_vector;
    covariance.columns(block(i), sensitivity.middleCols(at, n));
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(J);
  if (llt.info() != Eigen::Success) throw Diverged("a remembered motion is not determined");
  const Eigen::MatrixXd P_w = llt.solve(Eigen::MatrixXd::Identity(m, m));
  const Eigen::VectorXd w = llt.solve(j);
  for (std::size_t i = 0; i < released.size(); ++i) {
    const auto at = n * static_cast<Eigen::Index>(i);
    sensitivity.middleRows(block(i).offset, n).setZero();
    const StateBlock y = landmarks.at(released[i].track).y_block;
    // dy at this time, not at rest.
    sensitivity.block(y.offset, at, 3, n) += released[i].F_yw;
  }
  Eigen::MatrixXd P_xw = sensitivity * P_w;
  covariance.add_product(sensitivity.transpose().eval(), P_xw.transpose().eval());
  Eigen::VectorXd dx = sensitivity * w;
  for (std::size_t i = 0; i < released.size(); ++i) {
    const auto at = n * static_cast<Eigen::Index>(i);
    P_xw.middleRows(block(i).offset, n) = P_w.middleRows(at, n);
    dx.segment(block(i).offset, n) = w.segment(at, n);
  }
  for (std::size_t i = 0; i < released.size(); ++i) {
    const auto at = n * static_cast<Eigen::Index>(i);
    FilterLandmark& landmark = landmarks.at(released[i].track);
    const StateBlock own = landmark.constrained_block;
    covariance.assign(own, P_xw.middleCols(at, n), P_w.block(at, at, n, n));
    landmark.w.setZero(own.dim);
    landmark.w_block = own;
    landmark.information_vector.resize(0);
    landmark.constrained_block = {};
  }
  return dx;
}

void JointState::forget_motion(int track) {
  FilterLandmark& landmark = landmarks.at(track);
  remove_motion(landmark.information_vector, landmark.constrained_block);
}

}  // namespace slammot
