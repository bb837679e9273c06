// Where landmarks are expected, as stored with a run: what is not measured has the S that it would
// have if it were, and asking changes no estimate. That of an EKF is HPH' of its joint covariance:
// filters/test_state.cpp.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/run/run.h"
#include "tests/estimators/fixture/linearisation_fixture.h"

namespace slammot {
namespace {

using test::relative_difference;

struct Options {
  std::string name, estimator;
  std::vector<std::string> set;
};

void PrintTo(const Options& options, std::ostream* out) { *out << options.name; }

Configuration configuration_of(const Options& options) {
  Configuration configuration;
  for (const std::string& text : options.set) assign(configuration, parse_assignment(text));
  return configuration;
}

class PredictionsOf : public testing::TestWithParam<Options> {
 protected:
  static Sequence circle(const std::string& stereo = "0") {
    return simulate(
        "circle",
        {{"frames", "90"}, {"first_moving", "3"}, {"outliers", "0.02"}, {"stereo", stereo}}, 5);
  }
  static RunResult run(const Sequence& sequence, bool predictions) {
    DriveOptions options;
    options.predictions = predictions;
    return run_estimator(sequence, configuration_of(GetParam()), GetParam().estimator, options);
  }
};

// nu' S^-1 nu of what was accepted has the mean that the run states; of a rig nearly, since a run
// takes the pixels of a landmark together.
void expect_nis_of_the_run(const Sequence& sequence, const RunResult& result,
                           double tolerance = 1e-9) {
  std::map<std::tuple<int, int, int>, Eigen::Vector2d> measured;
  for (const Frame& frame : sequence.frames) {
    for (const auto* of : {&frame.observations, &frame.other_views}) {
      for (const Observation& z : *of) measured[{frame.index, z.track, z.camera}] = z.pixel;
    }
  }
  double sum = 0.0;
  int accepted = 0, rejected = 0, others = 0;
  for (const auto& [frame, p] : result.predictions) {
    ASSERT_EQ(p.measured != Measured::kNot, measured.contains({frame, p.track, p.camera}));
    rejected += p.measured == Measured::kRejected;
    others += p.measured == Measured::kNot;
    if (p.measured != Measured::kAccepted) continue;
    const Eigen::Vector2d nu = measured.at({frame, p.track, p.camera}) - p.pixel;
    sum += nu.dot(p.S.inverse() * nu);
    ++accepted;
  }
  EXPECT_EQ(accepted, result.totals.accepted);
  EXPECT_EQ(rejected, result.totals.rejected);
  EXPECT_GT(others, 10);
  EXPECT_NEAR(sum, result.totals.nis_sum, tolerance * sum);
}

TEST_P(PredictionsOf, ChangeNoEstimateAndHaveTheNisOfTheRun) {
  const Sequence sequence = circle();
  const RunResult result = run(sequence, true), without = run(sequence, false);
  EXPECT_GT(result.predictions.size(), 1000u);
  EXPECT_TRUE(without.predictions.empty());
  ASSERT_EQ(result.filtered.size(), without.filtered.size());
  for (std::size_t i = 0; i < result.filtered.size(); ++i) {
    const CameraState &x = result.filtered[i].state, &y = without.filtered[i].state;
    ASSERT_EQ(x.position, y.position);
    ASSERT_EQ(x.orientation.coeffs(), y.orientation.coeffs());
    ASSERT_EQ(result.filtered[i].covariance, without.filtered[i].covariance);
  }
  EXPECT_EQ(result.totals.nis_sum, without.totals.nis_sum);
  expect_nis_of_the_run(sequence, result);
}

TEST_P(PredictionsOf, OfARigAreThoseOfEachCamera) {
  const Sequence sequence = select_frames(circle("0.3"), 0, 39, 1);
  expect_nis_of_the_run(sequence, run(sequence, true), 0.03);
}

// Every tenth of the first frames twice: as it is, and without every other measurement.
TEST_P(PredictionsOf, OfWhatIsNotMeasuredAreAsIfItWere) {
  const Sequence sequence = circle();
  const Configuration configuration = configuration_of(GetParam());
  const slammot::Setup setup = make_setup(sequence, configuration);
  const EstimatorRow& row = find_estimator(GetParam().estimator);
  NoStages stages;
  double worst_pixel = 0.0, worst_S = 0.0;
  int compared = 0;
  for (std::size_t last = 9; last < 40; last += 10) {
    std::map<int, Prediction> all;
    for (const bool whole : {true, false}) {
      const auto estimator = row.make(setup, configuration);
      estimator->keep_predictions();
      for (std::size_t i = 0; i < last; ++i) estimator->process(sequence.frames[i], stages);
      Frame frame = sequence.frames[last];
      if (!whole) std::erase_if(frame.observations, [](const auto& z) { return z.track % 2 == 0; });
      for (const Prediction& p : estimator->process(frame, stages).predictions) {
        if (whole) {
          all.emplace(p.track, p);
        } else if (p.measured == Measured::kNot && all.contains(p.track)) {
          const Prediction& a = all.at(p.track);
          if (a.measured == Measured::kNot) continue;
          worst_pixel = std::max(worst_pixel, (a.pixel - p.pixel).norm());
          worst_S = std::max(worst_S, relative_difference(p.S, a.S));
          ++compared;
        }
      }
    }
  }
  EXPECT_GT(compared, 40);
  EXPECT_LT(worst_pixel, 1e-7);
  EXPECT_LT(worst_S, 1e-7);
}

INSTANTIATE_TEST_SUITE_P(Estimators, PredictionsOf,
                         testing::Values(Options{"ekf", "ekf", {}},
                                         Options{"ekf_heading", "ekf", {"gauge=heading"}},
                                         Options{"ekf_fej", "ekf", {"ekf.linearisation=fej"}},
                                         Options{"window", "window", {"window.frames=6"}}),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace slammot
