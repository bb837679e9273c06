#include "smoothers/linear/triangularise.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

// LAPACK's QR in compact WY form, recursive within a panel (Elmroth & Gustavson 2000): matrix
// products throughout, where Eigen's reflectors are vector by vector. The last arguments are the
// hidden lengths of the character arguments.
// NOLINTBEGIN(readability-identifier-naming)
extern "C" {
void dgeqrt_(const int* m, const int* n, const int* nb, double* a, const int* lda, double* t,
             const int* ldt, double* work, int* info);
void dgemqrt_(const char* side, const char* trans, const int* m, const int* n, const int* k,
              const int* nb, const double* v, const int* ldv, const double* t, const int* ldt,
              double* c, const int* ldc, double* work, int* info, std::size_t, std::size_t);
}
// NOLINTEND(readability-identifier-naming)

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

// A := Q'A, where Q makes the first `width` columns upper triangular; what is below their diagonal
// is left to hold the reflectors.
void reduce_panel(Eigen::MatrixXd& A, int width) {
  const auto m = static_cast<int>(A.rows()), rest = static_cast<int>(A.cols()) - width;
  const int k = std::min(m, width);
  Eigen::MatrixXd T(k, width), work(std::max(width, rest), k);
  int info = 0;
  dgeqrt_(&m, &width, &k, A.data(), &m, T.data(), &k, work.data(), &info);
  if (info == 0 && rest > 0) {
    dgemqrt_("L", "T", &m, &rest, &k, &k, A.data(), &m, T.data(), &k, A.col(width).data(), &m,
             work.data(), &info, 1, 1);
  }
  if (info != 0) throw std::logic_error("LAPACK refuses the arguments of a QR factorisation");
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
      reduce_panel(active, width);
      R.block(c, c, finished, n - c) = active.topRows(finished).triangularView<Eigen::Upper>();
    }
    carried = active.bottomRightCorner(active.rows() - finished, n - c - width).eval();
  }
  return R;
}

}  // namespace slammot
