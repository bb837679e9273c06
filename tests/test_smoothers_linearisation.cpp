// Where the window takes its Jacobians: a flag that is ignored is found out.
#include <gtest/gtest.h>

#include <random>

#include "slammot/datasets/scenario.h"
#include "slammot/eval/run.h"

namespace slammot {
namespace {

Sequence renoised(Sequence sequence, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  for (Frame& frame : sequence.frames) {
    for (Observation& z : frame.observations) {
      z.pixel += Eigen::Vector2d(normal(engine), normal(engine));
    }
  }
  return sequence;
}

// Of the last camera, with true labels and an open gate.
Matrix12d last_covariance(const std::string& linearisation, unsigned seed) {
  const Sequence sequence = renoised(simulate("matched", {{"frames", "40"}}, 1), seed);
  Configuration configuration;
  assign(configuration, {"landmark", "scaled_velocity"});
  assign(configuration, {"window.linearisation", linearisation});
  assign(configuration, {"window.frames", "5"});
  assign(configuration, {"gate.probability", "0.999999999999"});
  assign(configuration, {"prior.source", "stated"});
  assign(configuration, {"classifier", "truth"});
  assign(configuration, {"labels", "one_way"});
  const RunResult run = run_estimator(sequence, configuration, "window");
  EXPECT_FALSE(run.diverged);
  return run.filtered.back().covariance;
}

// The largest entry of A - B in units of B's sigmas.
double difference(const Matrix12d& A, const Matrix12d& B) {
  const Vector12d sigma = B.diagonal().cwiseSqrt();
  return (A - B).cwiseQuotient(sigma * sigma.transpose()).cwiseAbs().maxCoeff();
}

TEST(WindowLinearisation, IdealDoesNotDependOnTheMeasurements) {
  EXPECT_LT(difference(last_covariance("ideal", 1), last_covariance("ideal", 2)), 1e-9);
  EXPECT_GT(difference(last_covariance("standard", 1), last_covariance("standard", 2)), 1e-3);
  EXPECT_GT(difference(last_covariance("fej", 1), last_covariance("fej", 2)), 1e-3);
}

TEST(WindowLinearisation, EachIsAnother) {
  const Matrix12d standard = last_covariance("standard", 1), fej = last_covariance("fej", 1),
                  ideal = last_covariance("ideal", 1);
  EXPECT_GT(difference(standard, fej), 1e-3);
  EXPECT_GT(difference(standard, ideal), 1e-3);
  EXPECT_GT(difference(fej, ideal), 1e-3);
}

TEST(WindowLinearisation, IdealNeedsTheTruth) {
  Sequence sequence = simulate("matched", {{"frames", "3"}}, 1);
  Configuration configuration;
  assign(configuration, {"window.linearisation", "ideal"});
  sequence.exact_truth = false;
  EXPECT_THROW(run_estimator(sequence, configuration, "window"), std::invalid_argument);
}

}  // namespace
}  // namespace slammot
