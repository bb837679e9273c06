// From a configuration and a sequence to what an estimator is given.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "datasets/sequence/sequence.h"
#include "datasets/simulation/scenario.h"
#include "eval/configuration/configuration.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/run/run.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

using testing::HasSubstr;

TEST(MakeSetup, WarnsWhenEveryLandmarkWouldBeStaticAtOnce) {
  for (const char* landmark : {"dynamic_inverse_depth", "scaled_velocity"}) {
    SCOPED_TRACE(landmark);
    Configuration c;
    c.model.landmark = landmark;
    c.prior.inverse_depth = 0.2;
    c.prior.inverse_depth_sigma = 1e-6;
    c.prior.mean_sigma = 0.0;
    const auto warning = [&](double max_speed, const char* classifier = "thesis") {
      c.model.classifier.name = classifier;
      c.prior.max_speed = max_speed;
      return warning_about(make_setup(test::straight_line(2), c), c).value_or("");
    };
    EXPECT_EQ(warning(0.683), "");  // sigma_v = 0.3415 m/s: C_s = 1.594
    EXPECT_THAT(warning(0.681), HasSubstr("static_threshold = 1.6"));
    EXPECT_EQ(warning(0.681, "odds"), "");
  }
}

TEST(MakeSetup, ConfigurationThenSequenceThenDefault) {
  Sequence sequence = test::straight_line(2);
  sequence.pixel_sigma = 0.5;
  sequence.motion = StatedMotion{2.0, 3.0};
  sequence.truth[0]->position << 4, 5, 6;
  sequence.truth[0]->velocity << 1, 0, 0;
  Configuration configuration;
  configuration.motion.acceleration = 9.0;
  const slammot::Setup setup = make_setup(sequence, configuration);
  EXPECT_EQ(setup.pixel_sigma, 0.5);
  EXPECT_EQ(setup.camera_noise.acceleration, 9.0);
  EXPECT_EQ(setup.camera_noise.angular_acceleration, 3.0);
  EXPECT_EQ(setup.prior.inverse_depth, LandmarkPrior{}.inverse_depth);
  EXPECT_EQ(setup.initial.state.position, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(setup.initial.state.velocity, Eigen::Vector3d::Zero());  // at rest
  EXPECT_EQ(setup.true_labels.at(1), Label::kMoving);
  EXPECT_EQ(resolve(sequence, configuration).motion.angular_acceleration, 3.0);
}

// A front end that follows many points wants many landmarks; a user's own number holds.
TEST(Resolve, AsManyLandmarksAsTheFrontEndLooksFor) {
  Sequence sequence = test::straight_line(3);
  const auto visible = [&](const char* most = "sequence") {
    Configuration c;
    assign(c, {"policy.max_visible", most});
    return resolve(sequence, c).model.policy.max_visible;
  };
  EXPECT_EQ(visible(), 60);
  sequence.points = 30;
  EXPECT_EQ(visible(), 60);
  sequence.points = 150;
  EXPECT_EQ(visible(), 150);
  EXPECT_EQ(resolve(sequence, {}).model.policy.max_visible, 150);  // by default
  EXPECT_EQ(visible("25"), 25);
}

// Unless the sequence or the user states it; a velocity that is hardly known tells nothing.
TEST(MakeSetup, LandmarksMoveAsFastAsTheCamera) {
  Sequence sequence = test::straight_line(2);
  const auto max_speed = [&](const Configuration& c = {}) {
    return make_setup(sequence, c).prior.max_speed;
  };
  EXPECT_EQ(max_speed(), 2.0);
  sequence.initial = InitialCamera{};
  sequence.initial->state.velocity = {6.0, 0.0, 8.0};
  sequence.initial->velocity_sigma = 0.3;
  EXPECT_EQ(max_speed(), 10.0);
  sequence.initial->velocity_sigma = 5.1;
  EXPECT_EQ(max_speed(), 2.0);
  sequence.initial->velocity_sigma = 0.3;
  Configuration stated;
  stated.prior.max_speed = 3.0;
  EXPECT_EQ(max_speed(stated), 3.0);
  sequence.prior = LandmarkPrior{};
  sequence.prior->max_speed = 4.0;
  EXPECT_EQ(max_speed(), 4.0);
  sequence.prior.reset();
  sequence.initial->state.velocity = {0.5, 0.0, 0.0};
  sequence.initial->velocity_sigma = 0.1;
  EXPECT_EQ(max_speed(), 2.0);
}

// Where no depths are stated, those of known landmarks in view of the first frame are, if near.
TEST(MakeSetup, KnownLandmarksTellHowFarAwayTheSceneIs) {
  Sequence sequence = test::straight_line(2);
  const Eigen::Vector3d camera = sequence.truth[0]->position;
  sequence.known = {{7, camera + 2.0 * Eigen::Vector3d::UnitZ(), 0.01},
                    {8, camera + 1.0 * Eigen::Vector3d::UnitX(), 0.01},
                    {9, camera, 0.01}};  // no depth
  const auto prior = [&] { return make_setup(sequence, Configuration{}).prior; };
  const LandmarkPrior guess;
  sequence.frames[1].observations = {{7, {1.0, 2.0}}};
  EXPECT_EQ(prior().inverse_depth, guess.inverse_depth);  // not yet measured
  EXPECT_EQ(prior().mean_sigma, 1.0);
  sequence.frames[0].observations = {{7, {1.0, 2.0}}, {8, {3.0, 4.0}}, {9, {5.0, 6.0}}};
  EXPECT_DOUBLE_EQ(prior().inverse_depth, 0.75);
  EXPECT_DOUBLE_EQ(prior().inverse_depth_sigma, 0.75);
  EXPECT_DOUBLE_EQ(prior().mean_sigma, 0.75);
  EXPECT_TRUE(prior().spread_follows_mean);
  Configuration configuration;
  configuration.prior.inverse_depth = 0.1;
  EXPECT_EQ(make_setup(sequence, configuration).prior.inverse_depth, 0.1);
  EXPECT_EQ(make_setup(sequence, configuration).prior.inverse_depth_sigma,
            guess.inverse_depth_sigma);
  sequence.prior = guess;
  EXPECT_EQ(prior().inverse_depth, guess.inverse_depth);
  sequence.prior.reset();
  sequence.known = {{7, camera + 5.0 * Eigen::Vector3d::UnitZ(), 0.01}};
  EXPECT_DOUBLE_EQ(prior().inverse_depth, 0.2);  // far
  EXPECT_DOUBLE_EQ(prior().mean_sigma, 0.2);
}

// A sequence that states depths knows their spread and half knows their mean; one that states a
// sigma of the mean knows no more than that; one that states nothing knows neither.
TEST(MakeSetup, TheSpreadFollowsTheMeanWhereDepthsAreNotStatedAsKnown) {
  Sequence sequence = test::straight_line(2);
  sequence.known.push_back({1, Eigen::Vector3d::UnitZ(), 0.01});
  const auto prior = [&](const char* key = "prior.spread", const char* value = "auto") {
    Configuration configuration;
    assign(configuration, {key, value});
    return make_setup(sequence, configuration).prior;
  };
  const auto source = [&] { return resolve(sequence, Configuration{}).model.depth_prior; };
  EXPECT_EQ(source(), DepthPriorSource::kEmpirical);
  EXPECT_TRUE(prior().spread_follows_mean);
  EXPECT_FALSE(prior("prior.spread", "fixed").spread_follows_mean);
  EXPECT_FALSE(prior("prior.mean_sigma", "0").spread_follows_mean);
  EXPECT_EQ(prior("prior.inverse_depth", "0.1").mean_sigma, 0.05);  // the user states it
  EXPECT_FALSE(prior("prior.inverse_depth", "0.1").spread_follows_mean);
  sequence.prior = LandmarkPrior{};
  EXPECT_EQ(prior().mean_sigma, 0.5 * LandmarkPrior{}.inverse_depth);
  EXPECT_FALSE(prior().spread_follows_mean);
  EXPECT_TRUE(prior("prior.spread", "relative").spread_follows_mean);
  sequence.prior->mean_sigma = 0.07;
  EXPECT_EQ(prior().mean_sigma, 0.07);
  EXPECT_TRUE(prior().spread_follows_mean);
  sequence.known.clear();  // the statement is all that holds the scale, and is not given up
  EXPECT_EQ(source(), DepthPriorSource::kFixed);
  EXPECT_EQ(prior().mean_sigma, 0.0);
  EXPECT_FALSE(prior().spread_follows_mean);
}

TEST(Registry, NamesAdjustTheConfiguration) {
  EXPECT_THROW(find_estimator("kalman"), std::invalid_argument);
  // Its name until release 0.1, which claimed too much.
  EXPECT_THAT([] { find_estimator("bound"); },
              testing::ThrowsMessage<std::invalid_argument>(HasSubstr("ideal_covariance")));
  Configuration configuration;
  find_estimator("static_world").adjust(configuration);
  EXPECT_EQ(configuration.model.classifier.name, "all_static");
  EXPECT_EQ(configuration.model.labels.rule, LabelRule::kOneWay);
  find_estimator("delayed").adjust(configuration);
  EXPECT_TRUE(configuration.model.policy.delayed);
}

// Its own options decide whether an estimator is one.
TEST(Registry, Oracles) {
  Configuration configuration;
  const auto oracle = [&](const char* name) {
    return is_oracle(find_estimator(name), configuration);
  };
  EXPECT_FALSE(oracle("ekf"));
  EXPECT_TRUE(oracle("true_labels"));
  EXPECT_TRUE(oracle("ideal_covariance"));
  configuration.ekf.linearisation = FilterLinearisation::kIdeal;
  EXPECT_TRUE(oracle("delayed"));
  EXPECT_FALSE(oracle("window"));
  configuration = {};
  configuration.model.classifier.name = "truth";
  EXPECT_TRUE(oracle("window"));
  EXPECT_FALSE(oracle("static_world"));  // it labels by itself
}

TEST(Registry, TheIdealCovarianceHasThePriorThatIsStated) {
  const Sequence sequence = simulate("circle", {{"frames", "3"}}, 1);
  for (const char* mean_sigma : {"sequence", "0.1"}) {
    Configuration configuration;
    assign(configuration, {"prior.mean_sigma", mean_sigma});
    const Configuration ideal =
        effective_configuration(sequence, configuration, "ideal_covariance");
    EXPECT_EQ(ideal.model.depth_prior, DepthPriorSource::kFixed);
    EXPECT_EQ(make_setup(sequence, ideal).prior.mean_sigma, 0.0);
    EXPECT_GT(effective_configuration(sequence, configuration, "ekf").prior.mean_sigma, 0.0);
  }
}

}  // namespace
}  // namespace slammot
