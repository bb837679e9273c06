// A mover whose estimate is drawn to the camera must not hold the window where it is: at the
// camera's pole (observation.h) every step of the solution would put its pixel behind the camera.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

// Frames in which the camera turns on as it was predicted to, though it is measured. The camera's
// noise changes its rates by 4 degrees/s from one frame to the next.
int frames_that_stand(std::uint64_t seed) {
  Configuration configuration;
  assign(configuration, {"prior.acceleration", "1"});
  const Sequence sequence = simulate("circle", {{"frames", "150"}, {"moving", "1200"}}, seed);
  const RunResult run = run_estimator(sequence, configuration, "window");
  EXPECT_FALSE(run.diverged) << seed;
  int count = 0;
  for (std::size_t i = 2; i < run.filtered.size(); ++i) {
    const Eigen::Vector3d change =
        run.filtered[i].state.angular_velocity - run.filtered[i - 1].state.angular_velocity;
    count += change.norm() < 0.002 ? 1 : 0;  // [rad/s]
  }
  return count;
}

TEST(Pole, AMoverThatIsDrawnToItDoesNotStopTheWindow) {
  for (const std::uint64_t seed : {1u, 4u}) {
    EXPECT_EQ(frames_that_stand(seed), 0) << seed;
  }
}

}  // namespace
}  // namespace slammot
