// QR of a matrix that is nearly triangular already: a row takes part from the panel on in which its
// first column is.
#pragma once

#include <Eigen/Core>

namespace slammot {

// The upper triangular R (cols x cols) with R'R = A'A, A rows x cols; missing rows are zero.
// Householder panels touch only the rows that reach them, so that adding k rows to a triangle costs
// O(k cols^2).
Eigen::MatrixXd triangularise(const Eigen::MatrixXd& A);

}  // namespace slammot
