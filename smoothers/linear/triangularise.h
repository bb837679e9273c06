// QR factorisation in place of matrices whose rows begin at different columns.
#pragma once

#include <span>
#include <vector>

#include "models/lapack.h"

namespace slammot {

class Triangularise {
 public:
  // A := Q'A, where the first `last` columns become a staircase: each of the first rows begins
  // further right than the one above it. Row i of A begins at column starts[i], and starts ascend.
  // Columns before `first` are finished by the rows counted in `rows_of_first`; of `last` columns
  // by `rows`. Rows below are zero there, and hold what is left in the columns after.
  struct Staircase {
    Eigen::Index rows_of_first = 0, rows = 0;
  };
  Staircase operator()(MatrixRef A, std::span<const int> starts, Eigen::Index first,
                       Eigen::Index last);

 private:
  void reduce_panel(MatrixRef A, Eigen::Index width);

  std::vector<double> T_, work_;
};

// R of A = QR, square.
Eigen::MatrixXd triangular_factor(Eigen::MatrixXd A);

}  // namespace slammot
