// What goes wrong with a simulated recording, and that nothing else does.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"

namespace slammot {
namespace {

constexpr std::size_t kFrames = 60;
constexpr std::size_t kHalf = kFrames / 2;

Sequence circle(ScenarioOverrides overrides = {}) {
  overrides["frames"] = std::to_string(kFrames);
  return simulate("circle", overrides, 3);
}

TEST(Disturbances, OutliersAreAsManyAsWanted) {
  const Sequence clean = circle(), wrong = circle({{"outliers", "0.3"}});
  int moved = 0, all = 0;
  for (std::size_t i = 0; i < kFrames; ++i) {
    const auto &a = clean.frames[i].observations, &b = wrong.frames[i].observations;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k, ++all) {
      EXPECT_EQ(a[k].track, b[k].track);
      EXPECT_TRUE(a[k].pixel == b[k].pixel || wrong.camera.in_image(b[k].pixel));
      moved += a[k].pixel != b[k].pixel;
    }
  }
  const double sigma = std::sqrt(0.3 * 0.7 / all);
  EXPECT_NEAR(static_cast<double>(moved) / all, 0.3, 4.0 * sigma);
  EXPECT_EQ(clean.prior->inverse_depth, wrong.prior->inverse_depth);
  EXPECT_EQ(clean.initial->state.velocity, wrong.initial->state.velocity);
  EXPECT_THROW(circle({{"outliers", "1.1"}}), std::invalid_argument);
}

TEST(Disturbances, AGapMovesTheClockAlone) {
  const Sequence clean = circle(), late = circle({{"gap", "5"}});
  for (std::size_t i = 0; i < kFrames; ++i) {
    const double expected = clean.frames[i].timestamp + (i < kHalf ? 0.0 : 5.0);
    EXPECT_EQ(late.frames[i].timestamp, expected);
    EXPECT_EQ(late.truth[i]->position, clean.truth[i]->position);
    EXPECT_EQ(late.frames[i].observations.front().pixel,
              clean.frames[i].observations.front().pixel);
  }
  EXPECT_EQ(late.motion->acceleration, clean.motion->acceleration);
}

TEST(Disturbances, EmptyFramesStandInTheMiddle) {
  const Sequence blind = circle({{"empty", "2"}});  // of 59 / 15 s
  for (std::size_t i = 0; i < kFrames; ++i) {
    EXPECT_EQ(blind.frames[i].observations.empty(), i >= 15 && i < 45) << i;
  }
}

TEST(Disturbances, ATeleportIsSeenByTheCamera) {
  const Sequence clean = circle(), carried = circle({{"teleport", "4"}});
  for (std::size_t i = 0; i < kFrames; ++i) {
    const Eigen::Vector3d by = carried.truth[i]->position - clean.truth[i]->position;
    EXPECT_NEAR(by.norm(), i < kHalf ? 0.0 : 4.0, 1e-12);
    EXPECT_EQ(carried.truth[i]->velocity, clean.truth[i]->velocity);
  }
  // Its first measurements after it are those of the place where it is.
  const CameraState& there = *carried.truth[kHalf];
  for (const Observation& z : carried.frames[kHalf].observations) {
    const Eigen::Vector3d point =
        carried.landmarks.at(z.track).at(static_cast<int>(kHalf))->position;
    const Eigen::Vector3d ray = there.orientation.conjugate() * (point - there.position);
    EXPECT_LT((carried.camera.project(ray)->pixel - z.pixel).norm(), 6.0);
  }
}

}  // namespace
}  // namespace slammot
