// Stating a large acceleration of movers must not hide what rests (`prior.steady_time`).
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/metrics/metrics.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

TEST(SteadyTime, BoundsTheNoiseOfWhatIsNotKnownToMove) {
  LandmarkPrior prior;
  prior.max_speed = 4.0;
  prior.acceleration = 3.0;
  prior.jerk = 0.1;
  prior.steady_time = 10.0;
  EXPECT_EQ(prior.noise(true).acceleration, 3.0);
  EXPECT_DOUBLE_EQ(prior.noise(false).acceleration, 0.2);
  EXPECT_DOUBLE_EQ(prior.noise(false).jerk, 0.1);
  prior.jerk = 5.0;
  EXPECT_DOUBLE_EQ(prior.noise(false).jerk, 0.3);
  prior.acceleration = 0.1;
  EXPECT_EQ(prior.noise(false).acceleration, 0.1);
  prior.steady_time = 0.0;
  prior.acceleration = 3.0;
  EXPECT_EQ(prior.noise(false).acceleration, 3.0);
}

struct Found {
  double rmse = 0.0;
  int at_rest = 0;  // static ones that are called so
};

Found found(const Sequence& sequence, const std::string& family, double acceleration, double time) {
  Configuration configuration;
  configuration.prior.acceleration = acceleration;
  configuration.prior.steady_time = time;
  configuration.window.frames = 10;
  configuration.model.policy.movers = Movers::kJoint;  // so that they can draw the camera along
  configuration.ekf.second_order = false;              // protects the EKF too: 1.2 times at the end
  const EvaluatedRun run = run_and_evaluate(sequence, configuration, family, {});
  const Found result{run.metrics.filtered.accuracy.value->position_rmse,
                     run.metrics.classification.statics.right};
  std::printf("%s, %.1f m/s^2, %2.0f s: RMSE %.3f m, %d found at rest\n", family.c_str(),
              acceleration, time, result.rmse, result.at_rest);
  return result;
}

// On other seeds: eval/studies/unstated_acceleration.yaml.
TEST(SteadyTime, ALargeAccelerationDoesNotHideWhatRests) {
  const Sequence sequence = simulate("circle", {{"frames", "120"}}, 4);
  for (const char* family : {"ekf", "window"}) {
    const Found right = found(sequence, family, 0.1, 10.0);
    const Found large = found(sequence, family, 3.0, 10.0);
    const Found unbounded = found(sequence, family, 3.0, 0.0);
    EXPECT_GT(large.at_rest, 9 * right.at_rest / 10);
    EXPECT_LT(unbounded.at_rest, large.at_rest);
    EXPECT_LT(large.rmse, 1.5 * right.rmse);
    EXPECT_GT(unbounded.rmse, 1.4 * large.rmse);  // 3 where no label's motion is remembered
  }
}

}  // namespace
}  // namespace slammot
