// Where the window takes its Jacobians: a flag that is ignored is found out.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/run/run.h"
#include "tests/estimators/fixture/linearisation_fixture.h"

namespace slammot {
namespace {

// Of the last camera, with true labels and an open gate.
Matrix12d last_covariance(const std::string& linearisation, unsigned seed) {
  const Sequence sequence = test::renoised(simulate("model_matched", {{"frames", "40"}}, 1), seed);
  Configuration configuration;
  assign(configuration, {"landmark", "scaled_velocity"});
  assign(configuration, {"window.linearisation", linearisation});
  assign(configuration, {"window.frames", "5"});
  assign(configuration, {"gate.probability", "0.999999999999"});
  assign(configuration, {"gate.given_others", "1"});
  assign(configuration, {"prior.source", "fixed"});
  assign(configuration, {"classifier", "truth"});
  assign(configuration, {"labels", "one_way"});
  const RunResult run = run_estimator(sequence, configuration, "window");
  EXPECT_FALSE(run.diverged);
  return run.filtered.back().covariance;
}

using test::relative_difference;

TEST(WindowLinearisation, EachIsAnother) {
  EXPECT_GT(relative_difference(last_covariance("standard", 1), last_covariance("fej", 1)), 1e-3);
}

// Where nothing is known beforehand but the first camera, the first steps are long. Undamped, they
// sent landmarks behind the camera, and all four runs ended before frame 30. Scale is known from
// the first velocity only, so that positions say little.
TEST(WindowLinearisation, FirstEstimatesDampTheirStepsToo) {
  for (const unsigned seed : {1u, 2u}) {
    for (const double rho : {0.0, 0.1}) {
      const Sequence sequence =
          simulate("circle", {{"frames", "30"}, {"known", "0"}, {"noise", "0.2"}}, seed);
      Configuration configuration;
      assign(configuration, {"window.linearisation", "fej"});
      assign(configuration, {"window.frames", "10"});
      if (rho > 0.0) {  // two kinds of prior: the sequence's, and one of 5 m to infinity
        for (const char* key :
             {"prior.inverse_depth", "prior.inverse_depth_sigma", "prior.mean_sigma"}) {
          assign(configuration, {key, std::to_string(rho)});
        }
      }
      const RunResult run = run_estimator(sequence, configuration, "window");
      EXPECT_FALSE(run.diverged) << "seed " << seed;
      ASSERT_EQ(run.filtered.size(), sequence.frames.size()) << "seed " << seed;
      const Eigen::Quaterniond& last = run.filtered.back().state.orientation;
      EXPECT_LT(last.angularDistance(sequence.truth.back()->orientation), 0.01) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace slammot
