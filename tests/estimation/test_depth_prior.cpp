// What a newborn landmark's inverse depth is taken to be, from those already known.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estimation/modules/depth_prior.h"
#include "models/landmarks/scaled_velocity.h"
#include "models/points/inverse_depth.h"

namespace slammot {
namespace {

constexpr double kMean = 0.08, kSpread = 0.01, kKnown = 0.001;  // [1/m]

LandmarkPrior statement(double mean, double sigma) {
  LandmarkPrior prior;
  prior.inverse_depth = mean;
  prior.inverse_depth_sigma = sigma;
  return prior;
}

std::vector<SeenDepth> scene(int n, std::mt19937_64& engine) {
  std::normal_distribution<double> rho(kMean, kSpread);
  std::vector<SeenDepth> seen;
  for (int i = 0; i < n; ++i) seen.push_back({rho(engine), kKnown});
  return seen;
}

TEST(DepthPrior, AWrongGuessNoLongerDecides) {
  std::mt19937_64 engine(1);
  auto seen = scene(30, engine);
  for (const double guess : {kMean / 3.16, kMean, kMean * 3.16}) {
    const LandmarkPrior learnt = learnt_depth_prior(statement(guess, kSpread), seen);
    EXPECT_NEAR(learnt.inverse_depth, kMean, 0.01) << guess;
    EXPECT_GT(learnt.inverse_depth_sigma, 0.8 * kSpread);
    EXPECT_LT(learnt.inverse_depth_sigma, 4.0 * kSpread);
    // The prior of a scaled velocity follows.
    EXPECT_NEAR(ScaledVelocity<InverseDepth>::prior_sigmas(learnt).x(),
                std::hypot(learnt.inverse_depth, learnt.inverse_depth_sigma), 1e-12);
  }
}

// The next landmark of the same scene, in units of the sigma that was learnt: 1 or less on average,
// however small the sample. Of a scene that is as stated, and of one that is not.
TEST(DepthPrior, IsAsWideAsItsSampleSupports) {
  std::mt19937_64 engine(2);
  std::normal_distribution<double> next(kMean, kSpread);
  for (const int n : {4, 10, 40}) {
    for (const double stated : {1.0, 0.3}) {
      constexpr int kScenes = 4000;
      double squares = 0.0;
      for (int i = 0; i < kScenes; ++i) {
        auto seen = scene(n, engine);
        const LandmarkPrior learnt = learnt_depth_prior(statement(kMean, stated * kSpread), seen);
        const double z = (next(engine) - learnt.inverse_depth) / learnt.inverse_depth_sigma;
        squares += z * z / kScenes;
      }
      std::printf("%d landmarks, sigma stated as %g of the scene's: NEES %.2f\n", n, stated,
                  squares);
      EXPECT_GT(squares, 0.4);
      EXPECT_LT(squares, 1.1);
    }
  }
}

TEST(DepthPrior, WhoCounts) {
  std::mt19937_64 engine(3);
  const LandmarkPrior stated = statement(0.2, 0.1);
  auto few = scene(2, engine);
  EXPECT_EQ(learnt_depth_prior(stated, few).inverse_depth, 0.2);
  EXPECT_EQ(learnt_depth_prior(stated, few).inverse_depth_sigma, 0.1);
  auto guesses = few;
  guesses.insert(guesses.end(), 30, {0.2, 0.1});     // nothing is known of these
  guesses.insert(guesses.end(), 30, {-0.2, 0.001});  // nor is a point behind infinity a depth
  EXPECT_EQ(learnt_depth_prior(stated, guesses).inverse_depth, 0.2);
  auto ghost = scene(20, engine);
  ghost.push_back({10.0, 0.01});  // a moving point taken for static, at 10 cm
  const LandmarkPrior learnt = learnt_depth_prior(statement(kMean, kSpread), ghost);
  EXPECT_NEAR(learnt.inverse_depth, kMean, 2.5 * kSpread);
  EXPECT_LT(learnt.inverse_depth_sigma, kMean);
}

TEST(DepthPrior, BesideASharedMeanAWrongGuessIsNoSpread) {
  std::mt19937_64 engine(4);
  auto seen = scene(10, engine);
  LandmarkPrior shared = statement(3.0 * kMean, kSpread);
  const LandmarkPrior alone = learnt_depth_prior(shared, seen);
  shared.mean_sigma = 0.1;
  const LandmarkPrior learnt = learnt_depth_prior(shared, seen);
  EXPECT_GT(alone.inverse_depth_sigma, 3.0 * kSpread);
  EXPECT_LT(learnt.inverse_depth_sigma, 2.0 * kSpread);
  EXPECT_NEAR(learnt.inverse_depth, kMean, kSpread);
}

TEST(DepthPrior, Sources) {
  for (const bool some_are_known : {false, true}) {
    EXPECT_FALSE(learns_depths(DepthPriorSource::kFixed, {}, some_are_known));
    EXPECT_TRUE(learns_depths(DepthPriorSource::kEmpirical, {}, some_are_known));
    EXPECT_EQ(learns_depths(DepthPriorSource::kAuto, {}, some_are_known), some_are_known);
    EXPECT_EQ(DepthPrior(some_are_known, statement(0.2, 0.1)).of_new().inverse_depth, 0.2);
    InitialCamera driving;  // a first velocity known to a tenth holds the scale
    driving.state.velocity.z() = 8.0;
    driving.velocity_sigma = 0.8;
    EXPECT_TRUE(learns_depths(DepthPriorSource::kAuto, driving, some_are_known));
    driving.velocity_sigma = 8.0;
    EXPECT_EQ(learns_depths(DepthPriorSource::kAuto, driving, some_are_known), some_are_known);
  }
}

}  // namespace
}  // namespace slammot
