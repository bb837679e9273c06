// The unscented filter of third_family.cpp beside the EKF, and in the harness.
#include "tests/extending/third_family.h"

#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "eval/metrics/metrics.h"
#include "eval/run/run.h"
#include "models/landmarks/landmark_models.h"

namespace slammot {
namespace {

// With half as many landmarks as by default, in a quarter of the time.
Configuration quick() {
  Configuration configuration;
  configuration.model.policy.max_visible = 30;
  // It remembers no motions (Belief::constrained_motions), so that a static label must be surer.
  configuration.model.classifier.prior_odds = 1.0;
  return configuration;
}

// What a row makes of a sequence, by the functions that drive and judge every estimator.
struct Judged {
  RunResult run;
  RunMetrics metrics;
};

Judged judged(const EstimatorRow& row, const Sequence& sequence, Configuration configuration,
              const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
  row.adjust(configuration);
  slammot::Setup setup = make_setup(sequence, configuration);
  setup.initial.state.position += origin;
  for (KnownLandmark& known : setup.known) known.position += origin;
  const auto estimator = row.make(setup, configuration);
  Judged result{drive(sequence, *estimator), {}};
  result.metrics = compute_metrics(sequence, result.run, configuration.model.gate.probability);
  return result;
}

// The largest differences of b from a: of the cameras, b displaced by `origin`, in sigmas of a; of
// the sigmas, relative; of the moving landmarks' velocities, in sigmas of a.
struct Differences {
  double cameras = 0.0, sigmas = 0.0, velocities = 0.0;
};

Differences differences(const RunResult& a, const RunResult& b,
                        const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
  Differences largest;
  const auto raise = [](double& value, const auto& d) { value = std::max(value, d.maxCoeff()); };
  for (std::size_t i = 0; i < a.filtered.size(); ++i) {
    const Vector12d sigma = a.filtered[i].covariance.diagonal().cwiseSqrt();
    const Vector12d other = b.filtered[i].covariance.diagonal().cwiseSqrt();
    Vector12d d = boxminus(b.filtered[i].state, a.filtered[i].state);
    d.segment<3>(kPosition) -= origin;
    raise(largest.cameras, d.cwiseQuotient(sigma).cwiseAbs());
    raise(largest.sigmas, (other.cwiseQuotient(sigma).array() - 1.0).abs());
  }
  for (std::size_t i = 0; i < std::min(a.landmarks.size(), b.landmarks.size()); ++i) {
    const LandmarkEstimate &x = a.landmarks[i].estimate, &y = b.landmarks[i].estimate;
    if (!x.velocity.allFinite()) continue;
    const Eigen::Vector3d sigma = x.velocity_covariance.diagonal().cwiseSqrt();
    raise(largest.velocities, (y.velocity - x.velocity).cwiseQuotient(sigma).cwiseAbs());
  }
  return largest;
}

// No decision is left to a threshold that one of two filters may just miss: labels are given, and
// the gate is open.
class ThirdFamilyUndecided : public testing::Test {
 protected:
  ThirdFamilyUndecided() {
    configuration_.model.classifier.name = "truth";
    configuration_.model.labels.rule = LabelRule::kOneWay;
    configuration_.model.labels.births = Births::kStaticFirst;
    configuration_.model.gate = {0.999999, 1.0};
    configuration_.model.gauge = Gauge::kNone;
    configuration_.ekf.second_order = false;  // unscented ones have their own
  }

  RunResult run(const EstimatorRow& row) const {
    return judged(row, sequence_, configuration_).run;
  }

  const Sequence sequence_ = simulate("circle",
                                      {{"frames", "40"},
                                       {"first_moving", "3"},
                                       {"initial_velocity_sigma", "0.02"},
                                       {"initial_angular_velocity_sigma", "0.01"},
                                       {"stated_inverse_depth_sigma", "0.03"}},
                                      3);
  Configuration configuration_;
};

// Small first uncertainties make all functions nearly linear within them, and the unscented filter
// is the EKF up to terms of second order. Fastest to bend are velocities of new landmarks. A w in
// metres is predicted through its product with rho, which bends over a wide prior: the cameras then
// differ by more, and still by less than what either does not know.
TEST_F(ThirdFamilyUndecided, IsTheEkfWhereTheProblemIsNearlyLinear) {
  const std::string by_default = configuration_.model.landmark;
  for (const LandmarkFunctions& landmark : landmark_table(point_table().front())) {
    SCOPED_TRACE(landmark.name);
    configuration_.model.landmark = landmark.name;
    const RunResult ekf = run(find_estimator("ekf")), ukf = run(kUnscented);
    ASSERT_EQ(ukf.filtered.size(), 40u);
    ASSERT_EQ(ukf.landmarks.size(), ekf.landmarks.size());
    EXPECT_EQ(ukf.totals.accepted, ekf.totals.accepted);
    const Differences d = differences(ekf, ukf);
    EXPECT_LT(d.cameras, 1.0);
    if (landmark.name != by_default) continue;
    EXPECT_LT(d.cameras, 0.1);
    EXPECT_LT(d.sigmas, 0.01);
    EXPECT_GT(d.velocities, 0.0);  // some are estimated
    EXPECT_LT(d.velocities, 0.5);
  }
}

// With a label or a gate that one of them passes a frame later the cameras differ by more.
TEST(ThirdFamily, LabelsAsTheEkfDoes) {
  const Sequence sequence = simulate("circle", {{"frames", "40"}, {"first_moving", "0"}}, 3);
  for (const Collapse collapse : {Collapse::kCondition, Collapse::kDrop}) {
    SCOPED_TRACE(collapse == Collapse::kDrop ? "drop" : "condition");
    Configuration configuration = quick();
    configuration.model.collapse = collapse;
    configuration.model.labels.births = Births::kStaticFirst;
    configuration.model.classifier.name = "thesis";
    configuration.model.gate.given_others = 1.0;
    configuration.model.gauge = Gauge::kNone;
    const RunResult ekf = judged(find_estimator("ekf"), sequence, configuration).run;
    const RunResult ukf = judged(kUnscented, sequence, configuration).run;
    EXPECT_LT(differences(ekf, ukf).cameras, 1.0);
    ASSERT_EQ(ukf.landmarks.size(), ekf.landmarks.size());
    int classified = 0;
    for (std::size_t i = 0; i < ekf.landmarks.size(); ++i) {
      const LandmarkEstimate &x = ekf.landmarks[i].estimate, &y = ukf.landmarks[i].estimate;
      EXPECT_EQ(x.track, y.track);
      EXPECT_EQ(to_string(x.label), to_string(y.label)) << "track " << x.track;
      if (x.decision_frame) ++classified;
    }
    EXPECT_GT(classified, 10);
  }
}

TEST(ThirdFamily, LearnsNothingOfTheWorldsOrigin) {
  const Eigen::Vector3d origin(100.0, -50.0, 70.0);
  const Sequence sequence = simulate("circle", {{"frames", "20"}}, 3);
  const RunResult here = judged(kUnscented, sequence, quick()).run;
  const RunResult there = judged(kUnscented, sequence, quick(), origin).run;
  ASSERT_EQ(there.filtered.size(), 20u);
  EXPECT_LT(differences(here, there, origin).cameras, 1e-5);
  EXPECT_LT(differences(here, there, origin).sigmas, 1e-5);
}

// A third of the circle is 21 m long. The EKF's error stays below 1% of that.
TEST(ThirdFamily, IsNotLostAndClassifies) {
  const Sequence sequence = simulate("circle", {{"frames", "150"}}, 1);
  const auto [run, metrics] = judged(kUnscented, sequence, quick());
  ASSERT_FALSE(run.diverged);
  ASSERT_TRUE(metrics.filtered.accuracy.value);
  EXPECT_LT(metrics.filtered.accuracy.value->position_max, 0.01 * 21.0);
  const ClassificationMetrics& labels = metrics.classification;
  EXPECT_GT(labels.statics.right, 0.8 * labels.statics.all());
  EXPECT_GT(labels.movings.right, 0.6 * labels.movings.all());
  EXPECT_LT(labels.statics.wrong + labels.movings.wrong, 3);
}

// Its row is all that the harness asks for: stages, counts, consistency and labels come from the
// frame loop and eval/.
TEST(ThirdFamily, IsDrivenAndJudgedAsTheOthersAre) {
  const Sequence sequence = simulate("circle", {{"frames", "60"}}, 2);
  const Judged ekf = judged(find_estimator("ekf"), sequence, quick());
  const Judged ukf = judged(kUnscented, sequence, quick());
  ASSERT_EQ(ukf.run.timing.size(), ekf.run.timing.size());
  for (std::size_t i = 0; i < ekf.run.timing.size(); ++i) {
    ASSERT_EQ(ukf.run.timing[i].stage, ekf.run.timing[i].stage);
  }
  EXPECT_EQ(ukf.metrics.measurements.frames_done, 60);
  EXPECT_GT(ukf.metrics.measurements.pruned, 0);
  EXPECT_NEAR(ukf.metrics.measurements.accepted, ekf.metrics.measurements.accepted,
              0.02 * ekf.metrics.measurements.accepted);
  EXPECT_NEAR(ukf.metrics.nis.mean, ekf.metrics.nis.mean, 0.1);
  ASSERT_TRUE(ukf.metrics.filtered.consistency.value);
  EXPECT_EQ(ukf.metrics.filtered.consistency.value->pose.failures, 0);
  ASSERT_TRUE(ukf.metrics.landmark_consistency.value);
  EXPECT_GT(ukf.metrics.classification.movings.right, 0);
}

}  // namespace
}  // namespace slammot
