// Poses of past frames as later measurements correct them: in the EKF by clones, in the window
// because they are still there. What that buys: eval/studies/lag.yaml.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"
#include "smoothers/window/window.h"
#include "tests/estimators/fixture/linearisation_fixture.h"

namespace slammot {
namespace {

constexpr int kLag = 9;

Configuration configured() {
  Configuration configuration;
  configuration.model.classifier.name = "truth";
  configuration.model.labels.rule = LabelRule::kOneWay;
  configuration.ekf.lag = kLag;
  configuration.window.frames = kLag + 1;
  return configuration;
}

TEST(Lag, ChangesNothingOfTheFilter) {
  const Sequence sequence = simulate("circle", {{"frames", "30"}}, 5);
  Configuration configuration = configured();
  const slammot::Setup setup = make_setup(sequence, configuration);
  const auto with = make_ekf(setup, configuration.model, configuration.ekf);
  configuration.ekf.lag = 0;
  const auto without = make_ekf(setup, configuration.model, configuration.ekf);
  NoStages stages;
  for (const Frame& frame : sequence.frames) {
    with->process(frame, stages);
    without->process(frame, stages);
    const CameraEstimate a = with->camera(), b = without->camera();
    const Vector12d sigma = b.covariance.diagonal().cwiseSqrt();
    ASSERT_LT(boxminus(a.state, b.state).cwiseQuotient(sigma).norm(), 1e-6);
    ASSERT_LT((a.covariance - b.covariance).norm(), 1e-6 * b.covariance.norm());
  }
  EXPECT_FALSE(without->pose_before(1));
}

TEST(Lag, OfOneFrameIsThePoseBeforeUntilItIsMeasuredAgain) {
  Sequence sequence = simulate("circle", {{"frames", "30"}}, 5);
  sequence.frames[20].observations.clear();
  const Configuration configuration = configured();
  const auto ekf =
      make_ekf(make_setup(sequence, configuration), configuration.model, configuration.ekf);
  NoStages stages;
  for (int i = 0; i < 20; ++i) ekf->process(sequence.frames[static_cast<std::size_t>(i)], stages);
  const CameraEstimate before = ekf->camera();
  ekf->process(sequence.frames[20], stages);
  const auto lagged = ekf->pose_before(1);
  ASSERT_TRUE(lagged);
  EXPECT_LT((lagged->position - before.state.position).norm(), 1e-12);
  EXPECT_LT((lagged->covariance - before.covariance.topLeftCorner<6, 6>()).norm(),
            1e-12 * before.covariance.norm());
  EXPECT_FALSE(ekf->pose_before(kLag + 1));
}

// With estimates at the truth, labels given and no gate, both condition the same linear model on
// the same measurements: what they know of a past pose is the same. All positions are known to
// 10 cm, and as they are; pixels have no noise but are said to.
TEST(Lag, AtTheTruthEkfAndWindowKnowThePastAlike) {
  Sequence sequence = simulate(
      "circle", {{"frames", "30"}, {"moving", "0"}, {"noise", "1e-6"}, {"stated_noise", "1"}}, 3);
  Configuration configuration = configured();
  configuration.ekf.linearisation = FilterLinearisation::kIdeal;
  configuration.model.gate = {1.0, 1.0};
  configuration.model.adaptive_motion = false;
  sequence.known.clear();
  for (const auto& [track, landmark] : sequence.landmarks) {
    sequence.known.push_back({track, landmark.at(0)->position, 0.1});
  }
  const slammot::Setup setup = make_setup(sequence, configuration);
  const auto ekf = make_ekf(setup, configuration.model, configuration.ekf);
  const auto window = make_window(setup, configuration.model, configuration.window);
  NoStages stages;
  double worst = 0.0;
  int compared = 0;
  for (const Frame& frame : sequence.frames) {
    ekf->process(frame, stages);
    window->process(frame, stages);
    for (int lag = 1; lag <= kLag; ++lag) {
      const auto a = ekf->pose_before(lag), b = window->pose_before(lag);
      ASSERT_EQ(a.has_value(), b.has_value()) << "frame " << frame.index << " lag " << lag;
      if (!a) continue;
      const Eigen::Matrix<double, 6, 1> sigma = a->covariance.diagonal().cwiseSqrt();
      const Matrix6d difference = sigma.asDiagonal().inverse() * (a->covariance - b->covariance) *
                                  sigma.asDiagonal().inverse();
      worst = std::max(worst, difference.cwiseAbs().maxCoeff());
      ++compared;
    }
  }
  EXPECT_EQ(compared, 36 + 21 * kLag);  // from the tenth frame on all of them
  EXPECT_LT(worst, 0.02);
}

}  // namespace
}  // namespace slammot
