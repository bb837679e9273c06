// What the tests of linearisation share: the same scene with other noise, and how far apart two
// covariances are.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>

#include "datasets/sequence/sequence.h"

namespace slammot::test {

// The same scene and path with more pixel noise, of a pixel.
inline Sequence renoised(Sequence sequence, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  for (Frame& frame : sequence.frames) {
    for (Observation& z : frame.observations) {
      z.pixel += Eigen::Vector2d(normal(engine), normal(engine));
    }
  }
  return sequence;
}

// The largest entry of A - B in units of the standard deviations of B.
inline double relative_difference(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  EXPECT_TRUE(A.allFinite() && B.allFinite());
  const Eigen::VectorXd s = B.diagonal().cwiseSqrt();
  return (A - B).cwiseQuotient(s * s.transpose()).cwiseAbs().maxCoeff();
}

}  // namespace slammot::test
