#include "slammot/smoothers/triangularise.h"

#include <Eigen/QR>
#include <algorithm>
#include <vector>

namespace slammot {

namespace {

constexpr int kPanel = 32;

// Rows ordered by their first non-zero column; rows of zeros are left out.
std::vector<std::pair<int, int>> leading_columns(const Eigen::MatrixXd& A) {
  std::vector<int> first(static_cast<std::size_t>(A.rows()), static_cast<int>(A.cols()));
  for (int j = static_cast<int>(A.cols()) - 1; j >= 0; --j) {
    for (int i = 0; i < A.rows(); ++i) {
      if (A(i, j) != 0.0) first[static_cast<std::size_t>(i)] = j;
    }
  }
  std::vector<std::pair<int, int>> rows;
  for (int i = 0; i < A.rows(); ++i) {
    const int column = first[static_cast<std::size_t>(i)];
    if (column < A.cols()) rows.emplace_back(column, i);
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

}  // namespace

Eigen::MatrixXd triangularise(const Eigen::MatrixXd& A) {
  const int n = static_cast<int>(A.cols());
  const auto rows = leading_columns(A);
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXd carried(0, n);  // rows that earlier panels have touched, columns from c on
  std::size_t next = 0;
  for (int c = 0; c < n; c += kPanel) {
    const int width = std::min(kPanel, n - c);
    std::size_t end = next;
    while (end < rows.size() && rows[end].first < c + width) ++end;
    const auto fresh = static_cast<Eigen::Index>(end - next);
    Eigen::MatrixXd active(carried.rows() + fresh, n - c);
    active.topRows(carried.rows()) = carried;
    for (Eigen::Index i = 0; i < fresh; ++i, ++next) {
      active.row(carried.rows() + i) = A.row(rows[next].second).tail(n - c);
    }
    const Eigen::Index finished = std::min<Eigen::Index>(width, active.rows());
    if (active.rows() > 0) {
      Eigen::HouseholderQR<Eigen::MatrixXd> qr(active.leftCols(width));
      active.leftCols(width) = qr.matrixQR().triangularView<Eigen::Upper>();
      if (n - c > width) {
        active.rightCols(n - c - width).applyOnTheLeft(qr.householderQ().adjoint());
      }
      R.block(c, c, finished, n - c) = active.topRows(finished);
    }
    carried = active.bottomRightCorner(active.rows() - finished, n - c - width).eval();
  }
  return R;
}

}  // namespace slammot
