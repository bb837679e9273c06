// What each scenario promises; what `matched` does is in test_draws.cpp.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "datasets/simulation/scenario.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

TEST(Circle, EnoughIsSeenAndMoversAreAsFastAsTheyShould) {
  for (const std::uint64_t seed : {1u, 2u}) {
    const Sequence s = simulate("circle", {}, seed);
    ASSERT_EQ(s.frames.size(), 600u);
    for (const Frame& frame : s.frames) EXPECT_GE(frame.observations.size(), 8u) << frame.index;
    int moving_late = 0;
    for (const auto& [track, landmark] : s.landmarks) {
      EXPECT_EQ(landmark.label, track < 300 ? Label::kStatic : Label::kMoving);
      EXPECT_LT(track, 588);
      if (landmark.label == Label::kStatic) continue;
      for (const auto& [frame, point] : landmark.by_frame) {
        EXPECT_GE(point.velocity.norm(), 1.0 - 1e-12);
        EXPECT_LE(point.velocity.norm(), 2.0 + 1e-12);
        moving_late += frame >= 500;
      }
    }
    EXPECT_GT(moving_late, 200);
  }
}

void expect_closed(const Sequence& s) {
  for (size_t i = 0; i < 150; ++i) {
    EXPECT_LT(boxminus(*s.truth[i + 450], *s.truth[i]).norm(), 1e-9);
  }
}

TEST(Circle, GoesRoundAndOverItsStartAgainAtAChangingSpeed) {
  const Sequence s = simulate("circle", {}, 1);
  expect_closed(s);
  EXPECT_LT(s.truth[0]->position.norm(), 1e-12);
  EXPECT_LT(s.truth[0]->orientation.vec().norm(), 1e-12);
  std::set<int> first, again;
  for (const Observation& z : s.frames[0].observations) first.insert(z.track);
  for (const Observation& z : s.frames[450].observations) again.insert(z.track);
  for (const KnownLandmark& known : s.known) EXPECT_EQ(again.count(known.track), 1u);
  double least = 1e9, most = 0.0;
  for (const auto& x : s.truth) {
    least = std::min(least, x->velocity.norm());
    most = std::max(most, x->velocity.norm());
    EXPECT_NEAR((x->position - Eigen::Vector3d(10, 0, 0)).norm(), 10.0, 1e-9);
  }
  EXPECT_GT(most / least, 2.0);
}

TEST(Circle, PriorIsThatOfThePopulation) {
  const LandmarkPrior prior = *simulate("circle", {}, 1).prior;
  double sum = 0.0;
  int count = 0;
  for (const std::uint64_t seed : {1u, 2u}) {
    const Sequence s = simulate("circle", {}, seed);
    EXPECT_EQ(s.prior->inverse_depth, prior.inverse_depth);
    EXPECT_EQ(s.prior->inverse_depth_sigma, prior.inverse_depth_sigma);
    std::set<int> seen;
    for (const Frame& frame : s.frames) {
      for (const Observation& z : frame.observations) {
        if (!seen.insert(z.track).second || frame.index == 0) continue;
        const auto i = static_cast<size_t>(frame.index);
        sum +=
            1.0 / (s.landmarks.at(z.track).at(frame.index)->position - s.truth[i]->position).norm();
        ++count;
      }
    }
  }
  EXPECT_NEAR(sum / count, prior.inverse_depth, 4.0 * prior.inverse_depth_sigma / std::sqrt(count));
}

TEST(Circle, KnownPointsAreOffByTheirSigma) {
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Sequence s = simulate("circle", {{"known_sigma", "0.01"}, {"frames", "2"}}, seed);
    ASSERT_EQ(s.known.size(), 4u);
    for (const KnownLandmark& known : s.known) {
      squares += (known.position - s.landmarks.at(known.track).at(0)->position).squaredNorm();
    }
  }
  EXPECT_NEAR(squares / 120.0 / 1e-4, 1.0, 4.0 * std::sqrt(2.0 / 120.0));
}

TEST(Square, RunsAtConstantSpeedOnFourLinesAndClosesThem) {
  const Sequence s = simulate("square", {}, 1);
  const double speed = s.truth[0]->velocity.norm();
  int straight = 0;
  for (const auto& x : s.truth) {
    EXPECT_NEAR(x->velocity.norm(), speed, 1e-9);
    straight += x->angular_velocity.norm() < 1e-9;
    const Eigen::Vector3d p = x->position - Eigen::Vector3d(10, 0, 0);
    EXPECT_LE(p.lpNorm<Eigen::Infinity>(), 10.0 + 1e-9);
  }
  EXPECT_GT(straight, 400);
  expect_closed(s);
}

TEST(Helix, TargetsAreSeenThroughout) {
  for (const char* name : {"helix", "helix_unobservable"}) {
    const Sequence s = simulate(name, {}, 1);
    EXPECT_EQ(s.frames.size(), 150u);
    EXPECT_EQ(s.known.size(), 39u);
    EXPECT_EQ(s.landmarks.at(1).label, Label::kStatic);
    EXPECT_EQ(s.landmarks.at(2).at(1)->velocity, Eigen::Vector3d(1, 0, 0));
    EXPECT_EQ(s.landmarks.at(3).at(1)->velocity, Eigen::Vector3d(0, 0, 0.5));
    for (const Frame& frame : s.frames) {
      std::set<int> tracks;
      for (const Observation& z : frame.observations) tracks.insert(z.track);
      for (const int target : {1, 2, 3}) {
        EXPECT_EQ(tracks.count(target), frame.index == 0 ? 0u : 1u) << name << frame.index;
      }
      EXPECT_GE(tracks.size(), 10u) << name << frame.index;
    }
  }
}

TEST(HelixUnobservable, TheParallelMoverLooksLikeTheStaticTarget) {
  const Sequence s = simulate("helix_unobservable", {}, 1);
  const Sequence observable = simulate("helix", {}, 1);
  double apart = 0.0;
  for (size_t i = 1; i < s.frames.size(); ++i) {
    EXPECT_LT((*test::true_pixel(s, i, 1) - *test::true_pixel(s, i, 3)).norm(), 1e-9);
    apart = std::max(
        apart, (*test::true_pixel(observable, i, 1) - *test::true_pixel(observable, i, 3)).norm());
  }
  EXPECT_GT(apart, 10.0);
}

}  // namespace
}  // namespace slammot
