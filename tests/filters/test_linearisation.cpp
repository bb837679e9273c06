// Where the EKF takes its Jacobians: each value of the flag does what it says.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/metrics/metrics.h"
#include "eval/run/run.h"
#include "tests/estimators/fixture/linearisation_fixture.h"

namespace slammot {
namespace {

// The camera's covariance in the end, as a root mean variance of its entries' differences between
// two noise realisations, in sigmas.
double dependence_on_noise(const std::string& linearisation) {
  const Sequence sequence = simulate("model_matched", {{"frames", "40"}}, 1);
  Configuration configuration;
  assign(configuration, {"landmark", "dynamic_inverse_depth"});
  assign(configuration, {"ekf.linearisation", linearisation});
  assign(configuration, {"gate.probability", "0.999999999999"});
  assign(configuration, {"gate.given_others", "1"});
  assign(configuration, {"prior.source", "fixed"});  // what is learnt is of the measurements
  const auto last = [&](unsigned seed) {
    const RunResult run =
        run_estimator(test::renoised(sequence, seed), configuration, "true_labels");
    EXPECT_FALSE(run.diverged);
    return run.filtered.back().covariance;
  };
  return test::relative_difference(last(1), last(2));
}

TEST(Linearisation, IdealDoesNotDependOnTheMeasurements) {
  EXPECT_LT(dependence_on_noise("ideal"), 1e-9);
  EXPECT_GT(dependence_on_noise("standard"), 1e-3);
  EXPECT_GT(dependence_on_noise("fej"), 1e-3);
}

// Nothing says where the world's north is: the error of the first heading stays for ever. A filter
// whose Jacobians move from frame to frame believes to learn of it (Huang et al. 2008).
double heading_sigma(const std::string& linearisation, const std::string& gauge,
                     const std::string& classifier = "all_static") {
  Sequence sequence =
      simulate("circle", {{"frames", "120"}, {"moving", "0"}, {"known", "0"}, {"noise", "2"}}, 4);
  constexpr double kHeading = 0.2;  // [rad]
  sequence.initial->rotation_sigma = kHeading;
  sequence.initial->velocity_sigma = 10.0;  // a known velocity in W would tell north
  Configuration configuration;
  assign(configuration, {"ekf.linearisation", linearisation});
  assign(configuration, {"gauge", gauge});
  assign(configuration, {"classifier", classifier});
  const RunResult run = run_estimator(sequence, configuration, "ekf");
  EXPECT_FALSE(run.diverged);
  const Eigen::Matrix3d P = run.filtered.back().covariance.block<3, 3>(kRotation, kRotation);
  const Eigen::Vector3d down =
      run.filtered.back().state.orientation.conjugate() * Eigen::Vector3d::UnitY();
  return std::sqrt(down.dot(P * down)) / kHeading;
}

TEST(Linearisation, TheHeadingKeptIsNotInvented) {
  const double standard = heading_sigma("standard", "scale"), fej = heading_sigma("fej", "none"),
               ideal = heading_sigma("ideal", "none"), kept = heading_sigma("standard", "heading");
  std::printf(
      "sigma of the heading over its first: standard %.3f, fej %.3f, ideal %.3f, kept %.3f\n",
      standard, fej, ideal, kept);
  EXPECT_LT(standard, 0.5);
  EXPECT_GT(kept, 0.9);
}

// Here landmarks are found static, and labels are taken back, at estimates of w that are not zero.
TEST(Linearisation, TheHeadingKeptIsNotInventedWhereLandmarksCollapse) {
  EXPECT_GT(heading_sigma("standard", "heading", "thesis"), 0.9);
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
    const Sequence sequence = simulate("circle", {{"frames", "80"}, {"noise", noise}}, 3);
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
