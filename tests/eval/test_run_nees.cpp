// Whether one run's mean NEES is more than chance allows, and where that began.
#include "eval/statistics/run_nees.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slammot {
namespace {

// NEES of 6 numbers, each an AR(1) of this correlation from frame to frame.
std::vector<double> consistent(int frames, double correlation, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  std::vector<double> x(6), nees;
  for (double& v : x) v = normal(generator);
  for (int i = 0; i < frames; ++i) {
    double sum = 0.0;
    for (double& v : x) {
      v = correlation * v + std::sqrt(1.0 - correlation * correlation) * normal(generator);
      sum += v * v;
    }
    nees.push_back(sum);
  }
  return nees;
}

TEST(EffectiveSamples, AreThoseOfTheory) {
  EXPECT_NEAR(effective_samples(consistent(20000, 0.0, 1)) / 20000, 1.0, 0.1);
  // The square of an AR(1) has the correlation squared: n (1 - r^2) / (1 + r^2).
  const double r = 0.9 * 0.9;
  EXPECT_NEAR(effective_samples(consistent(20000, 0.9, 2)) / 20000, (1 - r) / (1 + r), 0.03);
}

TEST(RunNees, OfAConsistentRunIsAllowed) {
  int exceeding = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    exceeding += run_nees(consistent(600, 0.97, seed), 6).exceeds();
  }
  // One in a hundred by name. The correlation is estimated from the run itself, which costs a few.
  EXPECT_LE(exceeding, 16);
}

TEST(RunNees, SaysWhereItBegan) {
  std::vector<double> series = consistent(600, 0.9, 5);
  for (std::size_t i = 200; i < 600; ++i) series[i] *= 4.0;
  const RunNees late = run_nees(series, 6);
  ASSERT_TRUE(late.exceeds());
  EXPECT_NEAR(static_cast<double>(*late.began), 200.0, 15.0);
  for (double& v : series) v = 40.0;
  EXPECT_EQ(run_nees(series, 6).began, 0u);
}

TEST(RunNees, LeavesOutWhatIsNotFinite) {
  const RunNees some = run_nees({NAN, 5.0, INFINITY, 7.0}, 6);
  EXPECT_EQ(some.mean, 6.0);
  EXPECT_FALSE(some.exceeds());
  const RunNees none = run_nees({NAN}, 6);
  EXPECT_TRUE(std::isnan(none.mean));
  EXPECT_FALSE(none.exceeds());
}

}  // namespace
}  // namespace slammot
