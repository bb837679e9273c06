// Chi-square against published tables; NEES of samples whose covariance is known.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "eval/metrics/nees.h"
#include "eval/statistics/chi_square.h"
#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

TEST(ChiSquare, IntervalsOfTheLiterature) {
  struct Row {
    int dof, runs;
    double lower, upper;
  };
  // Bar-Shalom, Li & Kirubarajan for n = 4; the others computed independently (PEERS.md, section
  // E).
  const Row rows[] = {{2, 1, .051, 7.378},   {2, 50, 1.484, 2.591}, {3, 1, .216, 9.348},
                      {3, 20, 2.024, 4.165}, {3, 50, 2.360, 3.716}, {4, 25, 2.97, 5.18},
                      {6, 1, 1.237, 14.449}, {6, 50, 5.078, 6.997}, {6, 100, 5.340, 6.698},
                      {9, 100, 8.188, 9.850}};
  for (const Row& row : rows) {
    const Interval interval = nees_interval(row.dof, row.runs);
    const double rounding = row.dof == 4 ? 6e-3 : 6e-4;
    EXPECT_NEAR(interval.lower, row.lower, rounding) << row.dof << " " << row.runs;
    EXPECT_NEAR(interval.upper, row.upper, rounding) << row.dof << " " << row.runs;
  }
}

TEST(ChiSquare, ClosedFormsAndInverse) {
  for (const double x : {1e-6, 0.5, 3.0, 40.0}) {
    EXPECT_NEAR(chi_square_cdf(x, 2), -std::expm1(-x / 2), 1e-14);  // exponential
    EXPECT_NEAR(chi_square_cdf(x, 1), std::erf(std::sqrt(x / 2)), 1e-14);
  }
  EXPECT_EQ(chi_square_cdf(-1.0, 3), 0.0);
  for (const double p : {1e-6, 0.025, 0.5, 0.995}) {
    EXPECT_NEAR(chi_square_cdf(chi_square_quantile(p, 300), 300), p, 1e-10);
  }
  EXPECT_NEAR(chi_square_quantile(0.995, 3), 12.8382, 5e-5);  // the thesis's t_m squared
}

TEST(ChiSquare, MeanBelowTheGate) {
  EXPECT_NEAR(gated_mean(0.95, 2), 2.0 - 5.991464547 * 0.05 / 0.95, 1e-9);
  EXPECT_NEAR(gated_mean(1.0 - 1e-12, 2), 2.0, 1e-9);
}

Matrix6d some_covariance() {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const Matrix6d A = Matrix6d::NullaryExpr([&] { return normal(random); });
  return A * A.transpose() + 0.1 * Matrix6d::Identity();
}

std::vector<double> sampled_nees(const Matrix6d& truth, const Matrix6d& stated, int samples) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const Matrix6d L = truth.llt().matrixL();
  std::vector<double> values;
  for (int i = 0; i < samples; ++i) {
    const Vector6d e = L * Vector6d::NullaryExpr([&] { return normal(random); });
    values.push_back(nees(e, stated));
  }
  return values;
}

// The mean of N samples of chi-square(n) has standard error sqrt(2 n / N).
TEST(Nees, MeanOfAKnownGaussianIsItsDimension) {
  const Matrix6d P = some_covariance();
  const int samples = 20000;
  const double standard_error = std::sqrt(2.0 * 6.0 / samples);
  EXPECT_NEAR(mean(sampled_nees(P, P, samples)), 6.0, 4.0 * standard_error);
  const NeesSummary summary = summarise_nees(sampled_nees(P, P, samples), 6);
  EXPECT_NEAR(summary.interval_coverage, 0.95, 0.01);
  EXPECT_EQ(summary.failures, 0);
  // A covariance wrong by 10% must not pass.
  EXPECT_GT(std::abs(mean(sampled_nees(P, 0.9 * P, samples)) - 6.0), 4.0 * standard_error);
}

TEST(Nees, ABrokenCovarianceIsAFailureAndNeverZero) {
  const Eigen::Vector3d e(1, 0, 0);
  Eigen::Matrix3d indefinite = Eigen::Matrix3d::Identity();
  indefinite(2, 2) = -1.0;
  EXPECT_TRUE(std::isinf(nees(e, indefinite)));
  EXPECT_TRUE(std::isinf(nees(e, Eigen::Matrix3d::Zero())));
  EXPECT_TRUE(std::isinf(nees(e, Eigen::Matrix3d::Constant(kUndefined))));
  const NeesSummary summary = summarise_nees({1.0, 2.0, nees(e, indefinite)}, 3);
  EXPECT_EQ(summary.used, 3);
  EXPECT_EQ(summary.failures, 1);
  EXPECT_TRUE(std::isinf(summary.mean));
  EXPECT_DOUBLE_EQ(summary.median, 2.0);
  EXPECT_DOUBLE_EQ(summary.interval_coverage, 2.0 / 3.0);
}

TEST(Statistics, QuantilesAndNothing) {
  EXPECT_DOUBLE_EQ(median({3, 1, 2, 4}), 2.5);
  EXPECT_DOUBLE_EQ(quantile({0, 1, 2, 3, 4}, 0.95), 3.8);
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(median({infinity, infinity}), infinity);
  EXPECT_TRUE(std::isnan(mean({})));
  EXPECT_TRUE(std::isnan(root_mean_square({})));
  EXPECT_TRUE(std::isnan(median({})));
}

}  // namespace
}  // namespace slammot
