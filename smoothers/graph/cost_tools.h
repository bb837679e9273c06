// What cost functions share: writing a Jacobian where Ceres wants it, and weighting by a
// covariance.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <stdexcept>

#include "smoothers/graph/camera_manifold.h"

namespace slammot {

template <int Rows, int Cols>
using RowMajor = Eigen::Matrix<double, Rows, Cols, Cols == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

// Writes a Jacobian with respect to a Euclidean block, if Ceres wants it.
template <int Rows, int Cols>
void write(double** jacobians, int block, const Eigen::Matrix<double, Rows, Cols>& J) {
  if (!jacobians || !jacobians[block]) return;
  Eigen::Map<RowMajor<Rows, Cols>> out{jacobians[block]};
  out = J;
}

// The same for any number of rows and columns.
template <typename Derived>
void write_any(double** jacobians, int block, const Eigen::MatrixBase<Derived>& J) {
  if (!jacobians || !jacobians[block]) return;
  Eigen::Map<RowMajor<Eigen::Dynamic, Eigen::Dynamic>> out{jacobians[block], J.rows(), J.cols()};
  out = J;
}

// The same for the camera's motion, lifted from its 9 degrees of freedom.
template <int Rows>
void write_motion(double** jacobians, int block, const double* motion,
                  const Eigen::Matrix<double, Rows, kMotionDim>& J) {
  if (!jacobians || !jacobians[block]) return;
  RowMajor<kMotionDim, kMotionSize> lift;
  MotionManifold().MinusJacobian(motion, lift.data());
  Eigen::Map<RowMajor<Rows, kMotionSize>> out{jacobians[block]};
  out = J * lift;
}

// L^-1 of L L' = Q.
template <int N>
Eigen::Matrix<double, N, N> square_root_information(const Eigen::Matrix<double, N, N>& Q) {
  using Matrix = Eigen::Matrix<double, N, N>;
  const Eigen::LLT<Matrix> llt(Q);
  if (llt.info() != Eigen::Success) {
    throw std::invalid_argument(
        "the motion noise Q is singular: a smoother needs motion.discretisation=white_noise and "
        "sigmas above zero");
  }
  return llt.matrixL().solve(Matrix::Identity());
}

}  // namespace slammot
