// The triangular factor against the matrix it is of, and the staircase of matrices whose rows begin
// at different columns.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "smoothers/linear/triangularise.h"

namespace slammot {
namespace {

Eigen::MatrixXd normals(std::mt19937_64& engine, Eigen::Index rows, Eigen::Index cols) {
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return normal(engine); });
}

TEST(Triangularise, KeepsTheGram) {
  std::mt19937_64 engine(5);
  for (const auto& [rows, cols] : {std::pair{70, 70}, {120, 90}, {40, 90}, {5, 3}, {3, 5}}) {
    Eigen::MatrixXd A = normals(engine, rows, cols);
    for (int i = 0; i < rows / 2; ++i) A.row(i).head(std::min(i, cols)).setZero();
    const Eigen::MatrixXd R = triangular_factor(A);
    EXPECT_LT((R.transpose() * R - A.transpose() * A).norm(), 1e-12 * A.squaredNorm());
    EXPECT_EQ(R.rows(), cols);
    EXPECT_EQ(R.triangularView<Eigen::StrictlyLower>().toDenseMatrix().norm(), 0.0);
  }
}

struct Shape {
  Eigen::Index rows, cols, first, last;
};

// Rows that begin anywhere, more of them and fewer than columns, and gaps where none begins.
TEST(Triangularise, IsAStaircase) {
  std::mt19937_64 engine(6);
  for (const Shape& s : {Shape{150, 101, 40, 100},
                         {60, 101, 40, 100},
                         {300, 201, 33, 200},
                         {30, 41, 0, 40},
                         {30, 41, 20, 20},
                         {12, 101, 50, 100}}) {
    std::uniform_int_distribution<int> begin(0, static_cast<int>(s.last) - 1);
    std::vector<int> starts;
    for (Eigen::Index i = 0; i < s.rows; ++i) {
      const int start = begin(engine);
      starts.push_back(start / 7 % 3 == 0 ? start : start / 2);
    }
    std::ranges::sort(starts);
    Eigen::MatrixXd A = normals(engine, s.rows, s.cols);
    for (Eigen::Index i = 0; i < s.rows; ++i) {
      A.row(i).head(starts[static_cast<std::size_t>(i)]).setZero();
    }
    const Eigen::MatrixXd before = A;
    const auto rows = Triangularise()(A, starts, s.first, s.last);
    EXPECT_LT((A.transpose() * A - before.transpose() * before).norm(),
              1e-12 * before.squaredNorm());
    // Each row begins further right than the one above; rows below the staircase are zero there.
    int previous = -1;
    for (Eigen::Index i = 0; i < rows.rows; ++i) {
      int start = 0;
      while (start < s.cols && A(i, start) == 0.0) ++start;
      EXPECT_GT(start, previous) << "row " << i;
      EXPECT_EQ(start < s.first, i < rows.rows_of_first) << "row " << i;
      previous = start;
    }
    EXPECT_EQ(A.bottomRows(s.rows - rows.rows).leftCols(s.last).norm(), 0.0);
    EXPECT_EQ(A.bottomRows(s.rows - rows.rows_of_first).leftCols(s.first).norm(), 0.0);
    // What the first rows leave is what is known of the columns after, whatever the first are.
    const Eigen::Index n = s.first, m = s.cols - s.first;
    const Eigen::MatrixXd X = before.leftCols(n), Y = before.rightCols(m);
    Eigen::MatrixXd projected = Y;
    if (n > 0) projected -= X * X.completeOrthogonalDecomposition().solve(Y);
    const Eigen::MatrixXd rest = A.bottomRows(s.rows - rows.rows_of_first).rightCols(m);
    EXPECT_LT((rest.transpose() * rest - projected.transpose() * projected).norm(),
              1e-11 * before.squaredNorm());
  }
}

}  // namespace
}  // namespace slammot
