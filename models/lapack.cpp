#include "models/lapack.h"

// The last arguments are the hidden lengths of the character arguments.
// NOLINTBEGIN(readability-identifier-naming)
extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info, std::size_t);
void dlauum_(const char* uplo, const int* n, double* a, const int* lda, int* info, std::size_t);
void dtrtri_(const char* uplo, const char* diag, const int* n, double* a, const int* lda, int* info,
             std::size_t, std::size_t);
}
// NOLINTEND(readability-identifier-naming)

namespace slammot {

namespace {

// factor T B, or factor B T, in place of B; T is a lower triangle on this side of B.
void multiply_in_place(const char* side, double factor, const ConstMatrixRef& T, MatrixRef B) {
  const auto m = static_cast<int>(B.rows()), n = static_cast<int>(B.cols());
  const auto lda = static_cast<int>(T.outerStride()), ldb = static_cast<int>(B.outerStride());
  dtrmm_(side, "L", "N", "N", &m, &n, &factor, T.data(), &lda, B.data(), &ldb);
}

}  // namespace

bool cholesky_in_place(MatrixRef A) {
  const auto n = static_cast<int>(A.rows()), lda = static_cast<int>(A.outerStride());
  if (n == 0) return true;
  int info = 0;
  dpotrf_("L", &n, A.data(), &lda, &info, 1);
  return info == 0;
}

// [A 0; B C]^-1 = [A^-1 0; -C^-1 B A^-1 C^-1]. OpenBLAS's dtrtri alone goes column by column.
void invert_lower_in_place(MatrixRef L) {
  constexpr int kSmall = 32;
  const auto n = static_cast<int>(L.rows()), lda = static_cast<int>(L.outerStride());
  if (n <= kSmall) {
    int info = 0;
    if (n > 0) dtrtri_("L", "N", &n, L.data(), &lda, &info, 1, 1);
    return;
  }
  const int half = n / 2, rest = n - half;
  auto A = L.topLeftCorner(half, half), B = L.bottomLeftCorner(rest, half),
       C = L.bottomRightCorner(rest, rest);
  invert_lower_in_place(A);
  invert_lower_in_place(C);
  multiply_in_place("L", -1.0, C, B);
  multiply_in_place("R", 1.0, A, B);
}

void invert_cholesky_in_place(MatrixRef L) {
  const auto n = static_cast<int>(L.rows()), lda = static_cast<int>(L.outerStride());
  if (n == 0) return;
  invert_lower_in_place(L);
  int info = 0;
  dlauum_("L", &n, L.data(), &lda, &info, 1);
  for (Eigen::Index j = 1; j < n; ++j) L.col(j).head(j) = L.row(j).head(j).transpose();
}

void solve_lower_in_place(const ConstMatrixRef& L, MatrixRef B) {
  if (B.size() > 0) L.triangularView<Eigen::Lower>().solveInPlace(B);
}

}  // namespace slammot
