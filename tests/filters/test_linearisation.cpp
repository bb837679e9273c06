// Where the EKF takes its Jacobians: each value of the flag does what it says.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/metrics/metrics.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

// Nothing says where the world's north is: the error of the first heading stays for ever. A filter
// whose Jacobians move from frame to frame believes to learn of it (Huang et al. 2008).
double heading_sigma(const std::string& gauge, const std::string& classifier) {
  Sequence sequence =
      simulate("circle", {{"frames", "120"}, {"moving", "0"}, {"known", "0"}, {"noise", "2"}}, 4);
  constexpr double kHeading = 0.2;  // [rad]
  sequence.initial->rotation_sigma = kHeading;
  sequence.initial->velocity_sigma = 10.0;  // a known velocity in W would tell north
  Configuration configuration;
  assign(configuration, {"gauge", gauge});
  assign(configuration, {"classifier", classifier});
  const RunResult run = run_estimator(sequence, configuration, "ekf");
  EXPECT_FALSE(run.diverged);
  const Eigen::Matrix3d P = run.filtered.back().covariance.block<3, 3>(kRotation, kRotation);
  const Eigen::Vector3d down =
      run.filtered.back().state.orientation.conjugate() * Eigen::Vector3d::UnitY();
  return std::sqrt(down.dot(P * down)) / kHeading;
}

// Nor where landmarks are found static, and labels are taken back, at estimates of w that are not
// zero.
TEST(Linearisation, TheHeadingKeptIsNotInvented) {
  EXPECT_LT(heading_sigma("scale", "all_static"), 0.5);
  EXPECT_GT(heading_sigma("heading", "thesis"), 0.9);
}

TEST(Linearisation, UnknownNamesAndAMissingTruthAreRefused) {
  Sequence sequence = simulate("model_matched", {{"frames", "3"}}, 1);
  Configuration configuration;
  EXPECT_THROW(assign(configuration, {"ekf.linearisation", "perfect"}), std::invalid_argument);
  assign(configuration, {"ekf.linearisation", "ideal"});
  sequence.exact_truth = false;
  EXPECT_THROW(run_estimator(sequence, configuration, "ekf"), std::invalid_argument);
}

// The ideal covariance of a scene is the same whatever the noise of its pixels was.
TEST(IdealCovariance, DoesNotDependOnTheMeasurements) {
  Configuration configuration;
  configuration.pixel_sigma = 1.0;
  const auto run = [&](const char* noise) {
    const Sequence sequence = simulate("circle", {{"frames", "30"}, {"noise", noise}}, 3);
    const RunResult result = run_estimator(sequence, configuration, "ideal_covariance");
    const Configuration used = effective_configuration(sequence, configuration, "ideal_covariance");
    EXPECT_EQ(compute_metrics(sequence, result, used.model.gate.probability).nis.expected, 2.0);
    return result;
  };
  const RunResult quiet = run("0.1"), noisy = run("1.5");
  ASSERT_EQ(quiet.filtered.size(), noisy.filtered.size());
  EXPECT_EQ(noisy.totals.rejected, 0);
  for (std::size_t i = 0; i < quiet.filtered.size(); ++i) {
    const Matrix12d &a = quiet.filtered[i].covariance, &b = noisy.filtered[i].covariance;
    EXPECT_LT((a - b).norm(), 1e-9 * b.norm()) << "frame " << i;
  }
}

}  // namespace
}  // namespace slammot
