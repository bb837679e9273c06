#include "models/lapack.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

namespace slammot {
namespace {

// Sizes below and above those at which it goes by halves, in a larger matrix.
TEST(Lapack, InvertsATriangleAndItsProduct) {
  for (const Eigen::Index n : {0, 1, 2, 31, 32, 33, 64, 65, 131}) {
    Eigen::MatrixXd storage = Eigen::MatrixXd::Random(n + 7, n + 7);
    auto A = storage.topLeftCorner(n, n);
    const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(n, n);
    A = (A * A.transpose() + I).eval();
    const Eigen::MatrixXd before = A;
    ASSERT_TRUE(cholesky_in_place(A));
    const Eigen::MatrixXd L = A.triangularView<Eigen::Lower>(), above = A - L;
    Eigen::MatrixXd X = A;
    invert_lower_in_place(X);
    EXPECT_EQ(Eigen::MatrixXd(X.triangularView<Eigen::StrictlyUpper>()), above) << n;
    const Eigen::MatrixXd inverse = X.triangularView<Eigen::Lower>();
    EXPECT_LT((inverse * L - I).norm(), 1e-10) << n;
    invert_cholesky_in_place(A);
    EXPECT_LT((A * before - I).norm(), 1e-8) << n;
  }
  Eigen::MatrixXd no = -Eigen::MatrixXd::Identity(3, 3);
  EXPECT_FALSE(cholesky_in_place(no));
}

}  // namespace
}  // namespace slammot
