#include "smoothers/linear/lapack.h"

// The last arguments are the hidden lengths of the character arguments.
// NOLINTBEGIN(readability-identifier-naming)
extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info, std::size_t);
void dpotri_(const char* uplo, const int* n, double* a, const int* lda, int* info, std::size_t);
}
// NOLINTEND(readability-identifier-naming)

namespace slammot {

bool cholesky_in_place(MatrixRef A) {
  const auto n = static_cast<int>(A.rows()), lda = static_cast<int>(A.outerStride());
  if (n == 0) return true;
  int info = 0;
  dpotrf_("L", &n, A.data(), &lda, &info, 1);
  return info == 0;
}

void invert_cholesky_in_place(MatrixRef L) {
  const auto n = static_cast<int>(L.rows()), lda = static_cast<int>(L.outerStride());
  if (n == 0) return;
  int info = 0;
  dpotri_("L", &n, L.data(), &lda, &info, 1);
  for (Eigen::Index j = 1; j < n; ++j) L.col(j).head(j) = L.row(j).head(j).transpose();
}

void solve_lower_in_place(const ConstMatrixRef& L, MatrixRef B) {
  if (B.size() > 0) L.triangularView<Eigen::Lower>().solveInPlace(B);
}

}  // namespace slammot
