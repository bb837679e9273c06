// Where landmarks are expected, as stored with a run: S is that of the joint covariance, what is
// not measured has the S that it would have if it were, and asking changes no estimate.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/run/run.h"
#include "filters/ekf.h"
#include "models/points/observation.h"
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
  static Sequence circle() {
    return simulate("circle", {{"frames", "90"}, {"first_moving", "3"}, {"outliers", "0.02"}}, 5);
  }
  static RunResult run(const Sequence& sequence, bool predictions) {
    DriveOptions options;
    options.predictions = predictions;
    return run_estimator(sequence, configuration_of(GetParam()), GetParam().estimator, options);
  }
};

TEST_P(PredictionsOf, ChangeNoEstimate) {
  const Sequence sequence = circle();
  const RunResult with = run(sequence, true), without = run(sequence, false);
  EXPECT_GT(with.predictions.size(), 1000u);
  EXPECT_TRUE(without.predictions.empty());
  ASSERT_EQ(with.filtered.size(), without.filtered.size());
  for (std::size_t i = 0; i < with.filtered.size(); ++i) {
    ASSERT_EQ(with.filtered[i].state.position, without.filtered[i].state.position);
    ASSERT_EQ(with.filtered[i].state.orientation.coeffs(),
              without.filtered[i].state.orientation.coeffs());
    ASSERT_EQ(with.filtered[i].covariance, without.filtered[i].covariance);
  }
  EXPECT_EQ(with.totals.nis_sum, without.totals.nis_sum);
}

// nu' S^-1 nu of what was accepted has the mean that the run states.
TEST_P(PredictionsOf, HaveTheNisOfTheRun) {
  const Sequence sequence = circle();
  const RunResult result = run(sequence, true);
  std::map<std::pair<int, int>, Eigen::Vector2d> measured;
  for (const Frame& frame : sequence.frames) {
    for (const Observation& z : frame.observations) measured[{frame.index, z.track}] = z.pixel;
  }
  double sum = 0.0;
  int accepted = 0, rejected = 0, others = 0;
  for (const auto& [frame, p] : result.predictions) {
    ASSERT_EQ(p.measured != Measured::kNot, measured.contains({frame, p.track}));
    rejected += p.measured == Measured::kRejected;
    others += p.measured == Measured::kNot;
    if (p.measured != Measured::kAccepted) continue;
    const Eigen::Vector2d nu = measured.at({frame, p.track}) - p.pixel;
    sum += nu.dot(p.S.inverse() * nu);
    ++accepted;
  }
  EXPECT_EQ(accepted, result.totals.accepted);
  EXPECT_EQ(rejected, result.totals.rejected);
  EXPECT_GT(others, 10);
  std::printf("NIS %.6f of %d, in the run %.6f; %d rejected, %d not measured\n", sum / accepted,
              accepted, result.totals.nis_sum / accepted, rejected, others);
  EXPECT_NEAR(sum, result.totals.nis_sum, 1e-9 * sum);
}

// Every tenth frame twice: as it is, and without every other measurement.
TEST_P(PredictionsOf, OfWhatIsNotMeasuredAreAsIfItWere) {
  const Sequence sequence = circle();
  const Configuration configuration = configuration_of(GetParam());
  const slammot::Setup setup = make_setup(sequence, configuration);
  const EstimatorRow& row = find_estimator(GetParam().estimator);
  NoStages stages;
  double worst_pixel = 0.0, worst_S = 0.0;
  int compared = 0;
  for (std::size_t last = 9; last < sequence.frames.size(); last += 10) {
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
  std::printf("%d compared; largest difference: %.2g px, S %.2g\n", compared, worst_pixel, worst_S);
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

// Three landmarks, one free, two frames: S against P, with H by differences.
TEST(Predictions, OfAnEkfAreThoseOfItsJointCovariance) {
  slammot::Setup setup;
  setup.camera.width = 640;
  setup.camera.height = 480;
  setup.camera.fx = setup.camera.fy = 400.0;
  setup.camera.cx = 320.0;
  setup.camera.cy = 240.0;
  setup.pixel_sigma = 0.7;
  setup.prior.inverse_depth = 0.3;
  setup.prior.inverse_depth_sigma = 0.1;
  setup.initial.position_sigma = 0.1;
  setup.initial.rotation_sigma = 0.02;
  setup.initial.state.velocity = {0.3, -0.1, 0.5};
  setup.initial.state.angular_velocity = {0.05, 0.1, -0.1};
  const ModelOptions models;
  Ekf ekf(setup, models, {.second_order = false});
  const std::vector<Observation> first = {{1, {100, 90}}, {2, {330, 250}}, {3, {500, 400}}};
  TrackRecords records;
  ekf.predict({0, 0.0, first}, 0.0, setup.camera_noise, records);
  for (const Observation& z : first) {
    ASSERT_TRUE(ekf.add(z, setup.prior, z.track == 2));
    records[z.track] = initialised(z.track, 0, Label::kUnknown, setup.prior);
  }
  ekf.predict({1, 0.2, {}}, 0.2, setup.camera_noise, records);
  std::vector<Prediction> predictions;
  const std::vector<int> tracks = {1, 2, 3};
  ekf.predict_pixels(tracks, predictions);
  ASSERT_EQ(predictions.size(), 3u);

  const JointState& state = ekf.state();
  const PointFunctions& point = find_point(models.point);
  const Eigen::MatrixXd P = state.covariance.dense();
  for (const Prediction& p : predictions) {
    const FilterLandmark& l = state.landmarks.at(p.track);
    const FilterAnchor& anchor = state.anchors.at(l.anchor);
    const auto pixel = [&](const Eigen::VectorXd& dx) {
      const CameraState x = boxplus(state.camera, Vector12d(dx.head<12>()));
      return observe(setup.camera, point, x.position, x.orientation,
                     anchor.position + dx.segment<3>(anchor.block.offset),
                     l.y + dx.segment<3>(l.y_block.offset))
          ->pixel;
    };
    Eigen::MatrixXd H(2, P.cols());
    for (Eigen::Index i = 0; i < P.cols(); ++i) {
      const Eigen::VectorXd step = 1e-5 * Eigen::VectorXd::Unit(P.cols(), i);
      H.col(i) = (pixel(step) - pixel(-step)) / 2e-5;
    }
    const Eigen::Matrix2d HPHt = H * P * H.transpose();
    EXPECT_LT((p.pixel - pixel(Eigen::VectorXd::Zero(P.cols()))).norm(), 1e-12);
    EXPECT_LT(relative_difference(p.S, HPHt), 1e-7);
    // What they have in common counts: without it S is another.
    Eigen::MatrixXd apart = P;
    apart.topRightCorner(12, P.cols() - 12).setZero();
    apart.bottomLeftCorner(P.cols() - 12, 12).setZero();
    EXPECT_GT(relative_difference(H * apart * H.transpose(), HPHt), 0.01);
  }
}

}  // namespace
}  // namespace slammot
