// The key table: every key reads back what it writes, and mistakes are named.
#include <gtest/gtest.h>

#include "datasets/sequence/sequence.h"
#include "datasets/simulation/scenario.h"
#include "eval/configuration/configuration.h"
#include "eval/configuration/preset.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/run/run.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

std::string reason_of(const std::string& text) {
  Configuration configuration;
  try {
    assign(configuration, parse_assignment(text));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Configuration, EveryKeyTakesBackWhatItGives) {
  for (const ConfigurationKey& key : configuration_keys()) {
    Configuration configuration;
    const std::string text = key.get(configuration);
    key.set(configuration, text);
    EXPECT_EQ(key.get(configuration), text) << key.name;
    EXPECT_FALSE(key.help.empty()) << key.name;
  }
}

TEST(Configuration, AnUnknownKeyNamesTheNearest) {
  EXPECT_NE(reason_of("window.frame=3").find("window.frames"), std::string::npos);
  EXPECT_NE(reason_of("max_speed=3").find("prior.max_speed"), std::string::npos);
  EXPECT_NE(reason_of("landmrk=x").find("unknown key 'landmrk'"), std::string::npos);
}

TEST(Configuration, ABadValueIsRefusedWithItsReason) {
  EXPECT_EQ(reason_of("window.frames=many"), "window.frames: 'many' is not a whole number");
  EXPECT_EQ(reason_of("window.frames=3.5"), "window.frames: '3.5' is not a whole number");
  EXPECT_EQ(reason_of("pixel_sigma=nan"), "pixel_sigma: 'nan' is not a finite number");
  EXPECT_EQ(reason_of("pixel_sigma=0"), "pixel_sigma: '0' must be greater than 0");
  EXPECT_EQ(reason_of("gate.probability=1"), "");  // no gate
  EXPECT_EQ(reason_of("gate.probability=1.1"),
            "gate.probability: '1.1' must be above 0 and at most 1");
  EXPECT_NE(reason_of("landmark=cube").find("is not one of inverse_depth, "), std::string::npos);
  EXPECT_NE(reason_of("pixel_sigma").find("key=value"), std::string::npos);
}

TEST(Configuration, WhatWouldNotEndIsRefused) {
  EXPECT_EQ(reason_of("ekf.lag=500"), "");
  EXPECT_NE(reason_of("ekf.lag=501").find(" to 500"), std::string::npos);
  for (const std::string key : {"ekf.iterations", "window.iterations"}) {
    EXPECT_EQ(reason_of(key + "=1000"), "");
    EXPECT_EQ(reason_of(key + "=1001"), key + ": '1001' must be from 1 to 1000");
    EXPECT_EQ(reason_of(key + "=0"), key + ": '0' must be from 1 to 1000");
  }
  EXPECT_EQ(reason_of("ekf.lag=0"), "");
}

TEST(Configuration, YamlNestedOrDotted) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "c.yaml";
  test::write_text(file,
                   "window: {frames: 7, solver: ceres}\nclassifier:\n  name: odds\n"
                   "  decisive_odds: 20\nprior.max_speed: 3\nlandmark: scaled_velocity\n");
  Configuration c;
  EXPECT_EQ(load_configuration(c, file).size(), 6u);
  EXPECT_EQ(c.window.frames, 7);
  EXPECT_EQ(c.window.solver, WindowSolver::kCeres);
  EXPECT_EQ(c.model.classifier.name, "odds");
  EXPECT_EQ(c.model.classifier.decisive_odds, 20.0);
  EXPECT_EQ(c.prior.max_speed, 3.0);
  EXPECT_EQ(c.model.landmark, "scaled_velocity");
}

TEST(Configuration, YamlMistakesNameFileAndLine) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "c.yaml";
  const auto reason = [&](const std::string& text) -> std::string {
    test::write_text(file, text);
    Configuration c;
    try {
      load_configuration(c, file);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(reason("landmark: scaled_velocity\nwindow:\n  frame: 3\n").find("c.yaml:3: unknown"),
            std::string::npos);
  EXPECT_NE(reason("\npixel_sigma: -1\n").find("c.yaml:2: pixel_sigma: '-1'"), std::string::npos);
  EXPECT_NE(reason("a: [\n").find("c.yaml:"), std::string::npos);
  EXPECT_NE(reason("pixel_sigma: 1\npixel_sigma: 2\n").find("stands twice"), std::string::npos);
  EXPECT_NE(reason("pixel_sigma: [1]\n").find("c.yaml:1:"), std::string::npos);
  EXPECT_NE(reason("just text\n").find("c.yaml:1:"), std::string::npos);
  EXPECT_EQ(reason(""), "");
  EXPECT_NE(reason("? [a, b]\n: 1\n").find("c.yaml:1:"), std::string::npos);
}

TEST(Configuration, WhatIsGoneIsRefusedWithWhatToUseInstead) {
  const std::pair<const char*, const char*> gone[] = {
      {"classifier=bayes_factor", "use classifier=odds"},
      {"classifier.static_factor=20", "use classifier.decisive_odds"},
      {"ekf.equivariant_scale=false", "use gauge (scale; false: none)"},
      {"ekf.linearisation=invariant", "use gauge=heading"},
      {"ekf.static_enough=12", "use policy.movers (considered: as with 12; joint: as with 0)"},
      {"initial.velocity_sigma=1", "use the sequence's initial.yaml"},
      {"policy.lost_after=7", "use policy.prune_after"},
      {"prior.source=map", "use empirical"},
      {"window.linearisation=ideal", "use ekf.linearisation=ideal"},
      {"window.loss=huber", "use gate.probability"}};
  for (const auto& [setting, use] : gone) {
    EXPECT_NE(reason_of(setting).find(use), std::string::npos) << reason_of(setting);
  }
  for (const char* key :
       {"policy.probation", "policy.retain", "ekf.deferred", "window.retest", "window.prior",
        "labels.pooled", "labels.start", "labels.start_over", "labels.window", "frames.step",
        "labels.probability", "classifier.hidden_speed", "initial.angular_velocity_sigma"}) {
    const std::string reason = reason_of(std::string(key) + "=1");
    EXPECT_NE(reason.find("' is gone: "), std::string::npos) << key << ": " << reason;
    EXPECT_EQ(reason.find('\n'), std::string::npos) << key;
  }
}

std::map<std::string, std::string> values_of(const std::vector<std::string>& settings) {
  Configuration c;
  for (const std::string& text : settings) assign(c, parse_assignment(text));
  const auto all = key_values(c);
  return {all.begin(), all.end()};
}

TEST(Preset, SingleKeysOverrideItWhateverTheirOrder) {
  const auto first = values_of({"preset=thesis", "collapse=condition", "window.frames=5"});
  const auto last = values_of({"collapse=condition", "window.frames=5", "preset=thesis"});
  EXPECT_EQ(first, last);
  EXPECT_EQ(first.at("preset"), "thesis");
  EXPECT_EQ(first.at("collapse"), "condition");
  EXPECT_EQ(first.at("gauge"), "none");
  EXPECT_EQ(first.at("window.frames"), "5");
  // A key that is given its default is given all the same.
  EXPECT_EQ(values_of({"labels=reversible", "preset=thesis"}).at("labels"), "reversible");
  EXPECT_EQ(values_of({"preset=thesis", "preset=default"}), values_of({}));
  EXPECT_NE(reason_of("preset=montiel").find("is not one of default, thesis"), std::string::npos);
}

// A run repeated from its run.yaml has the preset's name and every value.
TEST(Preset, AFileIsRepeatedWhateverTheOrderOfItsKeys) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "c.yaml";
  test::write_text(file, "collapse: condition\npreset: thesis\n");
  Configuration c;
  load_configuration(c, file);
  EXPECT_EQ(c.model.collapse, Collapse::kCondition);
  EXPECT_EQ(c.model.policy.movers, Movers::kJoint);
}

// What the thesis leaves open stands in run.yaml with the value that is used.
TEST(Preset, StatesWhatTheThesisLeavesOpen) {
  const Sequence sequence = simulate("circle", {{"frames", "3"}}, 1);
  Configuration c;
  EXPECT_TRUE(left_open_by_the_thesis(resolve(sequence, c)).empty());
  assign(c, {"preset", "thesis"});
  const auto open = left_open_by_the_thesis(resolve(sequence, c));
  const std::map<std::string, std::string> by_key(open.begin(), open.end());
  EXPECT_EQ(by_key.at("pixel_sigma").rfind("1, ", 0), 0u) << by_key.at("pixel_sigma");
  EXPECT_EQ(by_key.at("gate.probability").rfind("0.95, ", 0), 0u);
  for (const auto& [key, how] : by_key) EXPECT_EQ(how.find("sequence, "), std::string::npos) << key;
}

TEST(MakeSetup, WarnsWhenEveryLandmarkWouldBeStaticAtOnce) {
  const Sequence sequence = test::straight_line(2);
  Configuration c;
  const auto warning = [&] { return warning_about(make_setup(sequence, c), c); };
  for (const char* landmark : {"dynamic_inverse_depth", "scaled_velocity"}) {
    SCOPED_TRACE(landmark);
    c = {};
    c.model.landmark = landmark;
    c.model.classifier.name = "thesis";
    c.prior.inverse_depth = 0.2;
    c.prior.inverse_depth_sigma = 1e-6;
    c.prior.mean_sigma = 0.0;
    c.prior.max_speed = 0.683;  // sigma_v = 0.3415 m/s: C_s = 1.594
    EXPECT_FALSE(warning());
    c.prior.max_speed = 0.681;
    ASSERT_TRUE(warning());
    EXPECT_NE(warning()->find("static_threshold = 1.6"), std::string::npos) << *warning();
    c.model.classifier.name = "odds";
    EXPECT_FALSE(warning());
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
  const auto visible = [&](const Configuration& c = {}) {
    return resolve(sequence, c).model.policy.max_visible;
  };
  EXPECT_EQ(visible(), 60);
  sequence.points = 30;
  EXPECT_EQ(visible(), 60);
  sequence.points = 150;
  EXPECT_EQ(visible(), 150);
  Configuration stated;
  assign(stated, {"policy.max_visible", "25"});
  EXPECT_EQ(visible(stated), 25);
  assign(stated, {"policy.max_visible", "sequence"});
  EXPECT_EQ(visible(stated), 150);
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

// Where nothing else states the scale, the statement is not given up.
TEST(MakeSetup, DepthsAreLearntWhereALandmarkIsKnown) {
  Sequence sequence = test::straight_line(2);
  EXPECT_EQ(resolve(sequence, Configuration{}).model.depth_prior, DepthPriorSource::kFixed);
  EXPECT_EQ(make_setup(sequence, Configuration{}).prior.mean_sigma, 0.0);
  sequence.known.push_back({1, Eigen::Vector3d::UnitZ(), 0.01});
  EXPECT_EQ(resolve(sequence, Configuration{}).model.depth_prior, DepthPriorSource::kEmpirical);
  EXPECT_EQ(make_setup(sequence, Configuration{}).prior.mean_sigma, 1.0);
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
  sequence.known.clear();  // the statement is all that holds the scale
  EXPECT_EQ(prior().mean_sigma, 0.0);
  EXPECT_FALSE(prior().spread_follows_mean);
}

TEST(Registry, NamesAreKnownAndAdjustTheConfiguration) {
  for (const char* name : {"ekf", "window", "batch", "static_world", "delayed", "true_labels"}) {
    EXPECT_EQ(find_estimator(name).name, name);
  }
  EXPECT_THROW(find_estimator("kalman"), std::invalid_argument);
  try {
    find_estimator("bound");  // its name until release 0.1, which claimed too much
    ADD_FAILURE();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("ideal_covariance"), std::string::npos);
  }
  Configuration configuration;
  find_estimator("static_world").adjust(configuration);
  EXPECT_EQ(configuration.model.classifier.name, "all_static");
  EXPECT_EQ(configuration.model.labels.rule, LabelRule::kOneWay);
  find_estimator("delayed").adjust(configuration);
  EXPECT_TRUE(configuration.model.policy.delayed);
}

// An estimator is compared with those of its kind; its own options decide whether it is an oracle.
TEST(Registry, KindsAndOracles) {
  EXPECT_EQ(find_estimator("window").kind, EstimatorKind::kSmoother);
  EXPECT_EQ(find_estimator("delayed").kind, EstimatorKind::kFilter);
  EXPECT_EQ(find_estimator("ideal_covariance").kind, EstimatorKind::kIdealCovariance);
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
