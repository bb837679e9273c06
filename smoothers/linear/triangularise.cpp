#include "smoothers/linear/triangularise.h"

#include <algorithm>
#include <stdexcept>

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

constexpr Eigen::Index kPanel = 32;

}  // namespace

// A := Q'A, where Q makes the first `width` columns upper triangular.
void Triangularise::reduce_panel(MatrixRef A, Eigen::Index width) {
  const auto m = static_cast<int>(A.rows()), n = static_cast<int>(width);
  const auto lda = static_cast<int>(A.outerStride()), rest = static_cast<int>(A.cols() - width);
  const int k = std::min(m, n);
  T_.resize(std::max(T_.size(), static_cast<std::size_t>(k * n)));
  work_.resize(std::max(work_.size(), static_cast<std::size_t>(std::max(n, rest) * k)));
  int info = 0;
  dgeqrt_(&m, &n, &k, A.data(), &lda, T_.data(), &k, work_.data(), &info);
  if (info == 0 && rest > 0) {
    dgemqrt_("L", "T", &m, &rest, &k, &k, A.data(), &lda, T_.data(), &k, A.col(width).data(), &lda,
             work_.data(), &info, 1, 1);
  }
  if (info != 0) throw std::logic_error("LAPACK refuses the arguments of a QR factorisation");
  A.leftCols(width).triangularView<Eigen::StrictlyLower>().setZero();
}

Triangularise::Staircase Triangularise::operator()(MatrixRef A, std::span<const int> starts,
                                                   Eigen::Index first, Eigen::Index last) {
  Staircase result;
  Eigen::Index top = 0, end = 0;
  const auto take_rows = [&](Eigen::Index column) {
    while (end < A.rows() && starts[static_cast<std::size_t>(end)] <= column) ++end;
    return end - top;
  };
  for (Eigen::Index c = 0; c < last;) {
    if (c == first) result.rows_of_first = top;
    const Eigen::Index until = c < first ? first : last;
    if (take_rows(c) == 0) {  // on to where a row begins
      c = end < A.rows() ? std::min<Eigen::Index>(until, starts[static_cast<std::size_t>(end)])
                         : until;
      continue;
    }
    // A panel ends where its rows are used up.
    Eigen::Index width = 0;
    while (width < std::min(kPanel, until - c) && take_rows(c + width) > width) ++width;
    reduce_panel(A.block(top, c, end - top, A.cols() - c), width);
    top += width;
    c += width;
  }
  if (first >= last) result.rows_of_first = top;
  result.rows = top;
  return result;
}

Eigen::MatrixXd triangular_factor(Eigen::MatrixXd A) {
  const std::vector<int> starts(static_cast<std::size_t>(A.rows()), 0);
  const Eigen::Index n = A.cols();
  Triangularise()(A, starts, n, n);
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n, n);
  const Eigen::Index rows = std::min(n, A.rows());
  R.topRows(rows) = A.topRows(rows).triangularView<Eigen::Upper>();
  return R;
}

}  // namespace slammot
