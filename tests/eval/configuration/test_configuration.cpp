// The key table: every key reads back what it writes, and mistakes are named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "eval/configuration/configuration.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

using testing::HasSubstr;

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
  EXPECT_THAT(reason_of("window.frame=3"), HasSubstr("window.frames"));
  EXPECT_THAT(reason_of("max_speed=3"), HasSubstr("prior.max_speed"));
  EXPECT_THAT(reason_of("landmrk=x"), HasSubstr("unknown key 'landmrk'"));
}

// Also one with which a run would not end.
TEST(Configuration, ABadValueIsRefusedWithItsReason) {
  for (const auto& [setting, reason] : std::vector<std::pair<std::string, std::string>>{
           {"window.frames=many", "window.frames: 'many' is not a whole number"},
           {"window.frames=3.5", "window.frames: '3.5' is not a whole number"},
           {"pixel_sigma=nan", "pixel_sigma: 'nan' is not a finite number"},
           {"pixel_sigma=0", "pixel_sigma: '0' must be greater than 0"},
           {"gate.probability=1", ""},  // no gate
           {"gate.probability=1.1", "gate.probability: '1.1' must be above 0 and at most 1"},
           {"ekf.lag=0", ""},
           {"ekf.lag=500", ""},
           {"ekf.iterations=0", "ekf.iterations: '0' must be from 1 to 1000"},
           {"ekf.iterations=1000", ""},
           {"window.iterations=1000", ""},
           {"window.iterations=1001", "window.iterations: '1001' must be from 1 to 1000"}}) {
    EXPECT_EQ(reason_of(setting), reason);
  }
  EXPECT_THAT(reason_of("ekf.lag=501"), HasSubstr(" to 500"));
  EXPECT_THAT(reason_of("landmark=cube"), HasSubstr("is not one of inverse_depth, "));
  EXPECT_THAT(reason_of("preset=montiel"), HasSubstr("is not one of default, thesis"));
  EXPECT_THAT(reason_of("pixel_sigma"), HasSubstr("key=value"));
}

// And in any order: what a preset sets gives way to what stands before it.
TEST(Configuration, YamlNestedOrDotted) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "c.yaml";
  test::write_text(
      file,
      "window: {frames: 7, solver: ceres}\nclassifier:\n  name: odds\n"
      "  decisive_odds: 20\nprior.max_speed: 3\nlandmark: scaled_velocity\npreset: thesis\n");
  Configuration c;
  EXPECT_EQ(load_configuration(c, file).size(), 7u);
  EXPECT_EQ(c.model.policy.movers, Movers::kJoint);
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
  for (const auto& [text, where] : std::vector<std::pair<std::string, std::string>>{
           {"landmark: scaled_velocity\nwindow:\n  frame: 3\n", "c.yaml:3: unknown"},
           {"\npixel_sigma: -1\n", "c.yaml:2: pixel_sigma: '-1'"},
           {"a: [\n", "c.yaml:"},
           {"pixel_sigma: 1\npixel_sigma: 2\n", "stands twice"},
           {"pixel_sigma: [1]\n", "c.yaml:1:"},
           {"just text\n", "c.yaml:1:"},
           {"- 1\n", "c.yaml:1:"},
           {"? [a, b]\n: 1\n", "c.yaml:1:"}}) {
    EXPECT_THAT(reason(text), HasSubstr(where));
  }
  EXPECT_EQ(reason(""), "");
}

// A key, a value of a key, and one for which there is nothing instead.
TEST(Configuration, WhatIsGoneIsRefusedWithWhatToUseInstead) {
  EXPECT_EQ(reason_of("window.loss=huber"),
            "'window.loss' is gone: use gate.probability and gate.given_others");
  EXPECT_EQ(reason_of("classifier=bayes_factor"),
            "'classifier=bayes_factor' is gone: use classifier=odds");
  EXPECT_EQ(reason_of("window.retest=1"), "'window.retest' is gone: use gate.given_others");
  EXPECT_THAT(reason_of("policy.retain=1"),
              testing::StartsWith("'policy.retain' is gone: nothing: "));
}

}  // namespace
}  // namespace slammot
