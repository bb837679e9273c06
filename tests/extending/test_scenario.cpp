// A scenario, as examples/extension/ adds one; its code stands there.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "datasets/simulation/scene/parameters.h"
#include "datasets/simulation/scene/random_stream.h"
#include "datasets/simulation/scene/recording.h"
#include "datasets/simulation/scene/statements.h"
#include "eval/run/run.h"
#include "examples/extension/corridor.h"

namespace slammot {
namespace {

TEST(ExtendingScenario, IsSimulatedWithOverridesAndRun) {
  CorridorOptions options;
  apply({{"corridor.frames", "20"}, {"width", "3"}}, "corridor", parameters(options));
  EXPECT_THROW(apply({{"widht", "3"}}, "corridor", parameters(options)), std::invalid_argument);
  const Sequence sequence = simulate_corridor(options, 5), again = simulate_corridor(options, 5);
  ASSERT_EQ(sequence.frames.size(), 20u);
  ASSERT_FALSE(sequence.frames[0].observations.empty());
  EXPECT_EQ(sequence.frames[7].observations[0].pixel, again.frames[7].observations[0].pixel);
  const RunResult run = run_estimator(sequence, Configuration{}, "ekf");
  EXPECT_FALSE(run.diverged);
  EXPECT_EQ(run.filtered.size(), 20u);
}

}  // namespace
}  // namespace slammot
