// When movers are said to accelerate, on innovations whose distribution is known.
#include <gtest/gtest.h>

#include <random>

#include "estimation/landmark_noise.h"

namespace slammot {
namespace {

// How many innovations, `scale` times chi-square(2), until movers accelerate; `limit` if never.
int until_rejected(double scale, int limit, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::exponential_distribution<double> half_chi_square;
  LandmarkNoise noise(true);
  for (int i = 0; i < limit; ++i) {
    if (noise.scale() > 0.0) return i;
    noise.note_innovation(scale * 2.0 * half_chi_square(engine));
  }
  return limit;
}

TEST(LandmarkNoise, RightInnovationsKeepTheVelocityAndLargeOnesRejectIt) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    EXPECT_EQ(until_rejected(1.0, 5000, seed), 5000);  // as many as a run of the circle has
    EXPECT_LT(until_rejected(2.0, 5000, seed), 300);
  }
}

TEST(LandmarkNoise, AFewOutliersRejectNothing) {
  LandmarkNoise noise(true);
  for (int i = 0; i < 1000; ++i) noise.note_innovation(i % 50 == 0 ? 1e6 : 1.9);
  EXPECT_EQ(noise.scale(), 0.0);
}

TEST(LandmarkNoise, OnceRejectedItIsAsStated) {
  LandmarkNoise noise(true);
  for (int i = 0; i < 50; ++i) noise.note_innovation(8.0);
  EXPECT_EQ(noise.scale(), 1.0);
  for (int i = 0; i < 1000; ++i) noise.note_innovation(0.1);
  EXPECT_EQ(noise.scale(), 1.0);
  EXPECT_EQ(LandmarkNoise(false).scale(), 1.0);
}

}  // namespace
}  // namespace slammot
