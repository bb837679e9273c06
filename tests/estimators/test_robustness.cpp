// What every estimator of the registry must survive, whatever it is: it inherits these tests by its
// row.
#include <gtest/gtest.h>

#include <functional>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"

namespace slammot {
namespace {

std::unique_ptr<Estimator> make(const std::string& name, const Sequence& sequence) {
  const EstimatorRow& row = find_estimator(name);
  Configuration configuration;
  configuration.window.frames = 4;
  row.adjust(configuration);
  return row.make(make_setup(sequence, configuration), configuration);
}

class EveryEstimator : public testing::TestWithParam<std::string> {
 protected:
  Sequence sequence_ =
      simulate("circle", {{"frames", "25"}, {"static", "150"}, {"moving", "100"}}, 5);
  NoStages stages_;

  // Runs to the end; every estimate is a number and every covariance positive definite.
  void run(Estimator& estimator) {
    for (const Frame& frame : sequence_.frames) {
      estimator.process(frame, stages_);
      const CameraEstimate camera = estimator.camera();
      ASSERT_TRUE(camera.state.position.allFinite());
      ASSERT_TRUE(camera.state.orientation.coeffs().allFinite());
      ASSERT_EQ(camera.covariance.llt().info(), Eigen::Success) << "frame " << frame.index;
      EXPECT_EQ(camera.timestamp, frame.timestamp);
    }
    for (const CameraEstimate& camera : estimator.smoothed(stages_)) {  // a batch solves here
      ASSERT_TRUE(camera.state.position.allFinite());
    }
    for (const LandmarkEstimate& l : estimator.landmarks()) {
      EXPECT_GE(l.observations, l.by_rule ? 0 : 1);
      const bool has_velocity = !std::isnan(l.velocity_covariance(0, 0));
      EXPECT_TRUE(l.label != Label::kStatic || !has_velocity);
    }
  }
};

TEST_P(EveryEstimator, RunsAndIsTheSameTwice) {
  const auto a = make(GetParam(), sequence_), b = make(GetParam(), sequence_);
  run(*a);
  run(*b);
  EXPECT_EQ(a->camera().state.position, b->camera().state.position);
  EXPECT_EQ(a->camera().covariance, b->camera().covariance);
  EXPECT_LT((a->camera().state.position - sequence_.truth.back()->position).norm(), 1.0);
}

TEST_P(EveryEstimator, SurvivesWhatItCannotUse) {
  const Sequence good = sequence_;
  const auto survives = [&](const char* what, const std::function<void(Frame&)>& spoil) {
    SCOPED_TRACE(what);
    for (Frame& frame : sequence_.frames) spoil(frame);
    EXPECT_NO_THROW(run(*make(GetParam(), sequence_)));
    sequence_ = good;
  };
  survives("nothing at all", [](Frame& frame) { frame.observations.clear(); });
  survives("nothing for a while, then new tracks alone", [](Frame& frame) {
    if (frame.index >= 10 && frame.index < 13) frame.observations.clear();
    for (Observation& z : frame.observations) z.track += frame.index < 15 ? 0 : 100000;
  });
  int track = 0;
  survives("landmarks seen once", [&](Frame& frame) {
    for (Observation& z : frame.observations) z.track = ++track;
  });
  sequence_.initial->state.velocity.setZero();
  sequence_.initial->state.angular_velocity.setZero();
  survives("a camera at rest",
           [&](Frame& frame) { frame.observations = good.frames[0].observations; });
}

TEST_P(EveryEstimator, RefusesTimeThatStandsStill) {
  const auto estimator = make(GetParam(), sequence_);
  estimator->process(sequence_.frames[0], stages_);
  EXPECT_THROW(estimator->process(sequence_.frames[0], stages_), std::invalid_argument);
}

TEST_P(EveryEstimator, WithoutNoiseMakesNoError) {
  const Sequence truth = simulate(
      "circle", {{"frames", "15"}, {"static", "150"}, {"moving", "0"}, {"noise", "1e-6"}}, 5);
  sequence_ = truth;
  sequence_.initial->state = *truth.truth[0];
  sequence_.landmarks.clear();
  sequence_.known.clear();
  for (const auto& [track, landmark] : truth.landmarks) {
    sequence_.known.push_back({track, landmark.at(0)->position, 1e-3});
  }
  const auto estimator = make(GetParam(), sequence_);
  run(*estimator);
  EXPECT_LT((estimator->camera().state.position - truth.truth.back()->position).norm(), 1e-4);
}

std::vector<std::string> names() {
  std::vector<std::string> names;
  for (const EstimatorRow& row : estimator_table()) names.emplace_back(row.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Registry, EveryEstimator, testing::ValuesIn(names()),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace slammot
