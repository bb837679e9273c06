// What is stated of the movers' acceleration, in whole runs.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

class StatedAcceleration : public testing::TestWithParam<std::string> {
 protected:
  RunResult run(const Sequence& sequence, double acceleration) const {
    Configuration configuration;
    configuration.prior.acceleration = acceleration;
    configuration.window.frames = 5;
    return run_estimator(sequence, configuration, GetParam());
  }

  // Largest difference of a filtered position between two statements [m].
  double difference(const Sequence& sequence) const {
    const RunResult little = run(sequence, 0.03), much = run(sequence, 1.0);
    EXPECT_EQ(little.filtered.size(), sequence.frames.size());
    EXPECT_EQ(much.filtered.size(), sequence.frames.size());
    double largest = 0.0;
    for (std::size_t i = 0; i < std::min(little.filtered.size(), much.filtered.size()); ++i) {
      const Eigen::Vector3d apart =
          little.filtered[i].state.position - much.filtered[i].state.position;
      largest = std::max(largest, apart.norm());
    }
    return largest;
  }
};

TEST_P(StatedAcceleration, MakesNoDifferenceWhereNobodyAccelerates) {
  EXPECT_EQ(difference(simulate("circle", {{"frames", "100"}}, 1)), 0.0);
}

TEST_P(StatedAcceleration, IsUsedWhereMoversAccelerate) {
  EXPECT_GT(
      difference(simulate("model_matched", {{"frames", "100"}, {"object_acceleration", "1"}}, 1)),
      1e-3);
}

INSTANTIATE_TEST_SUITE_P(Families, StatedAcceleration, testing::Values("ekf", "window"),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace slammot
