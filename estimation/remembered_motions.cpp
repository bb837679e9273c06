#include "estimation/remembered_motions.h"

#include <Eigen/Cholesky>

namespace slammot {

void RememberedMotions::reset(Eigen::Index landmarks, int dim) {
  dim_ = dim;
  tracks_.clear();
  y_.clear();
  J_.setZero(dim * landmarks, dim * landmarks);
  j_.setZero(dim * landmarks);
}

void RememberedMotions::add(int track, const Eigen::Vector3d& y) {
  tracks_.push_back(track);
  y_.push_back(y);
}

std::optional<MotionBelief> RememberedMotions::motion(std::size_t i,
                                                      const LandmarkFunctions& functions) const {
  const MotionMatrix J = J_.block(row(i), row(i), dim_, dim_);
  const Eigen::LLT<MotionMatrix> llt(J);
  if (llt.info() != Eigen::Success) return std::nullopt;
  MotionBelief motion;
  motion.track = tracks_[i];
  motion.w = llt.solve(MotionVector(j_.segment(row(i), dim_)));
  motion.covariance = llt.solve(MotionMatrix::Identity(dim_, dim_));
  motion.density_scale = functions.density_scale(landmark_state(y_[i], motion.w));
  return motion;
}

bool RememberedMotions::release(std::size_t i) {
  const MotionMatrix J_rr = J_.block(row(i), row(i), dim_, dim_);
  const Eigen::LLT<MotionMatrix> llt(J_rr);
  if (llt.info() != Eigen::Success) return false;
  const Eigen::MatrixXd J_r = J_.middleCols(row(i), dim_);
  const MotionVector w = llt.solve(MotionVector(j_.segment(row(i), dim_)));
  j_ -= J_r * w;
  J_ -= J_r * llt.solve(J_r.transpose());
  // Zero but for rounding: it is determined no more.
  J_.middleCols(row(i), dim_).setZero();
  J_.middleRows(row(i), dim_).setZero();
  return true;
}

}  // namespace slammot
