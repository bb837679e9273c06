// The triangular factor against the matrix it is of.
#include <gtest/gtest.h>

#include <random>

#include "smoothers/linear/triangularise.h"

namespace slammot {
namespace {

TEST(Triangularise, KeepsTheGram) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  for (const auto& [rows, cols] : {std::pair{70, 70}, {120, 90}, {40, 90}, {5, 3}, {3, 5}}) {
    Eigen::MatrixXd A(rows, cols);
    for (double& v : A.reshaped()) v = normal(engine);
    for (int i = 0; i < rows / 2; ++i) A.row(i).head(std::min(i, cols)).setZero();
    const Eigen::MatrixXd R = triangularise(A);
    EXPECT_LT((R.transpose() * R - A.transpose() * A).norm(), 1e-12 * A.squaredNorm());
    EXPECT_EQ(R.rows(), cols);
    EXPECT_EQ(R.triangularView<Eigen::StrictlyLower>().toDenseMatrix().norm(), 0.0);
  }
}

}  // namespace
}  // namespace slammot
