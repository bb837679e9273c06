// The few routines of LAPACK that are called without Eigen between: in place, and with no memory of
// their own.
#pragma once

#include <Eigen/Core>

namespace slammot {

using MatrixRef = Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using ConstMatrixRef = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

// Lower Cholesky factor in place of the lower triangle; false when A is not positive definite.
bool cholesky_in_place(MatrixRef A);

// L^-1 in place of the lower triangle L; the upper one is left as it is.
void invert_lower_in_place(MatrixRef L);

// A^-1 in place of its Cholesky factor; both triangles.
void invert_cholesky_in_place(MatrixRef L);

// L^-1 B in place of B.
void solve_lower_in_place(const ConstMatrixRef& L, MatrixRef B);

}  // namespace slammot
