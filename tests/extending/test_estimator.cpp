// An estimator, as examples/extension/ adds one; its code stands there.
#include <gtest/gtest.h>

#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/metrics/metrics.h"
#include "eval/run/run.h"
#include "examples/extension/dead_reckoning.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

TEST(ExtendingEstimator, IsDrivenAndJudged) {
  // [example: driving]
  Sequence sequence = test::straight_line(5);  // x = 0, 1, 2, ... m, one second apart
  sequence.initial.emplace();
  sequence.initial->state.velocity = {1.0, 0.0, 0.0};

  const Configuration configuration;
  const auto setup = make_setup(sequence, configuration);
  const std::unique_ptr<Estimator> estimator = kDeadReckoning.make(setup, configuration);
  const RunResult run = drive(sequence, *estimator);
  const RunMetrics metrics = compute_metrics(sequence, run, configuration.model.gate.probability);
  // [end]
  ASSERT_FALSE(run.diverged);
  ASSERT_EQ(run.filtered.size(), 5u);
  ASSERT_TRUE(metrics.filtered.accuracy.value);
  EXPECT_LT(metrics.filtered.accuracy.value->position_rmse, 1e-12);
  EXPECT_GT(run.filtered[4].covariance(0, 0), run.filtered[3].covariance(0, 0));
}

}  // namespace
}  // namespace slammot
