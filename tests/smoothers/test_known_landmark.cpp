// A landmark known beforehand enters the window with what was stated of it.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "tests/smoothers/fixture/looped_window.h"

namespace slammot {
namespace {

TEST(KnownLandmark, WhoseFirstPixelIsRefusedIsAsItWasStated) {
  Sequence sequence = simulate("circle", {{"frames", "1"}}, 3);
  ASSERT_FALSE(sequence.known.empty());
  const KnownLandmark& known = sequence.known.front();
  Frame& frame = sequence.frames.front();
  for (Observation& z : frame.observations) {
    if (z.track == known.track) z.pixel += Eigen::Vector2d(150.0, 90.0);
  }
  LoopedWindow run(sequence, {});
  EXPECT_EQ(run.process(frame).rejected, 1);
  int found = 0;
  for (const LandmarkEstimate& l : run.loop->landmarks_measured(0)) {
    if (l.track != known.track) continue;
    ++found;
    const Eigen::Matrix3d stated = known.sigma * known.sigma * Eigen::Matrix3d::Identity();
    EXPECT_LT((l.position - known.position).norm(), known.sigma);
    EXPECT_LT((l.position_covariance - stated).norm(), 0.01 * stated.norm());
  }
  EXPECT_EQ(found, 1);
}

}  // namespace
}  // namespace slammot
