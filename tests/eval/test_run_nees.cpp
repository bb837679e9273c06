// Whether one run's mean NEES is more than chance allows, where that began, and the NEES of several
// runs together.
#include "eval/statistics/run_nees.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "eval/pooling/frame_statistics.h"

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

TEST(EffectiveSamples, OfAlternatingNumbersAreAtMostTheirNumber) {
  EXPECT_EQ(effective_samples({1.0, -1.0, 1.0, -1.0}), 4.0);
  EXPECT_EQ(effective_samples({0.0, 1.0, 0.0}), 3.0);
}

TEST(EffectiveSamples, OfHugeNumbersAreDefined) {
  EXPECT_EQ(effective_samples({11.3, 1e300, 4.4}), 3.0);
  EXPECT_EQ(effective_samples({1e300, 1e300, 0.0, 0.0}), effective_samples({1.0, 1.0, 0.0, 0.0}));
  EXPECT_TRUE(run_nees({11.3, 1e300, 4.4}, 6).exceeds());
}

TEST(RunNees, OfALineThatHasANegativeOneIsRefused) {
  nlohmann::ordered_json frames = {{"frame", {1}}};
  for (const char* key : {"position_error_m", "rotation_error_deg", "nees_pose", "nees_position",
                          "nees_rotation", "position_sigma_m"}) {
    frames[key] = {1.0};
  }
  EXPECT_NO_THROW(FrameStatistics().add(frames));
  frames["nees_pose"] = {-1e300};
  EXPECT_THROW(FrameStatistics().add(frames), nlohmann::ordered_json::exception);
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

TEST(RunNees, LeavesOutWhatIsNotDefined) {
  const RunNees some = run_nees({NAN, 5.0, 7.0}, 6);
  EXPECT_EQ(some.mean, 6.0);
  EXPECT_FALSE(some.exceeds());
  const RunNees none = run_nees({NAN}, 6);
  EXPECT_TRUE(std::isnan(none.mean));
  EXPECT_FALSE(none.exceeds());
}

TEST(RunNees, IsInfiniteFromTheFirstCovarianceThatIsNotPositiveDefinite) {
  const RunNees run = run_nees({5.0, NAN, INFINITY, 7.0}, 6);
  EXPECT_EQ(run.mean, INFINITY);
  EXPECT_TRUE(run.exceeds());
  EXPECT_EQ(run.began, 2u);
}

// A run of so many frames, all with this NEES.
nlohmann::ordered_json frames_of(int count, double nees) {
  std::vector<int> frame(static_cast<std::size_t>(count));
  std::iota(frame.begin(), frame.end(), 1);
  const std::vector<double> same(frame.size(), nees), error(frame.size(), 0.1);
  return {{"frame", frame},
          {"position_error_m", error},
          {"rotation_error_deg", error},
          {"position_sigma_m", error},
          {"nees_pose", same}};
}

TEST(FrameStatistics, TheMeanOfRunsThatEndEarlyLiesInItsOwnInterval) {
  FrameStatistics statistics;
  for (int run = 0; run < 47; ++run) statistics.add(frames_of(600, 6.0));
  for (int run = 0; run < 3; ++run) statistics.add(frames_of(60, 500.0));
  const auto pose = statistics.anees()["pose"];
  const double poses = 47 * 600 + 3 * 60;
  EXPECT_NEAR(pose["mean"].get<double>(), (47 * 600 * 6.0 + 3 * 60 * 500.0) / poses, 1e-9);
  EXPECT_LT(pose["lower"].get<double>(), pose["mean"].get<double>());
  EXPECT_GT(pose["upper"].get<double>(), pose["mean"].get<double>());
  EXPECT_EQ(pose["runs"], 50);
}

TEST(FrameStatistics, WithoutAnIntervalNoFrameIsOutsideIt) {
  auto frames = frames_of(20, 6.0);
  for (const char* part : {"landmark_position", "landmark_velocity"}) {
    frames[std::string("nees_") + part] = std::vector<double>(20, 3.0);
    frames[std::string(part) + "_count"] = std::vector<int>(20, 5);
  }
  FrameStatistics statistics;
  statistics.add(frames);
  EXPECT_TRUE(std::isnan(statistics.anees()["landmark_position"]["inside"].get<double>()));
  EXPECT_EQ(statistics.anees()["pose"]["inside"], 1.0);
}

TEST(FrameStatistics, CovariancesThatNobodyStatedHaveNoNees) {
  Sequence sequence;
  sequence.exact_truth = true;
  std::vector<PosePair> pairs(3);
  for (PosePair& pair : pairs) pair.estimate.covariance.setConstant(NAN);
  pairs[1].estimate.covariance.topLeftCorner<3, 3>().setIdentity();
  const auto frames = judged_frames(sequence, pairs);
  EXPECT_TRUE(frames.contains("nees_position"));  // stated of one pose
  EXPECT_FALSE(frames.contains("nees_pose"));
  EXPECT_FALSE(frames.contains("nees_rotation"));
  FrameStatistics statistics;
  statistics.add(frames);
  EXPECT_FALSE(statistics.anees().contains("pose"));
  EXPECT_GT(statistics.anees()["position"]["infinite"], 0);
}

}  // namespace
}  // namespace slammot
