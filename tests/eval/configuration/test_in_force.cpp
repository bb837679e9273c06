// What a run states to be in force (estimation/in_force.h) beside what acts, for every pair of
// values of the options that switch a mechanism:
// - stated off, or on without having acted: the estimates are those with its key at off, bit by
// bit;
// - stated on and acted: they differ;
// - an option that nothing states changes the estimates. So none is without effect in silence.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/configuration.h"
#include "eval/run/process.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

struct Option {
  std::string key;
  std::vector<std::string> values;  // the first: off, as in the thesis
};

// Values that are other choices of a key, not the mechanism that it switches.
const std::set<std::string> kOtherChoices = {"labels.births=free", "ekf.linearisation=ideal"};

using Settings = std::map<std::string, std::string>;

std::vector<Option> options_of(const std::string& estimator) {
  std::vector<Option> options = {{"landmark", {"dynamic_inverse_depth", "scaled_velocity"}},
                                 {"point", {"inverse_depth", "xyz"}},
                                 {"collapse", {"drop", "condition"}},
                                 {"gate.given_others", {"1", "0.999"}},
                                 {"classifier", {"thesis", "odds"}},
                                 {"labels", {"one_way", "reversible"}},
                                 {"labels.memory", {"0", "60"}},
                                 {"labels.births", {"static_first", "free", "held"}},
                                 {"policy.movers", {"joint", "considered"}},
                                 {"motion.adaptive", {"false", "true"}},
                                 {"gauge", {"none", "heading", "scale"}},
                                 {"prior.source", {"fixed", "empirical"}}};
  const std::vector<Option> of_filters = {{"ekf.linearisation", {"standard", "fej", "ideal"}},
                                          {"ekf.iterations", {"1", "3"}},
                                          {"ekf.second_order", {"false", "true"}}};
  const std::vector<Option> of_windows = {{"window.linearisation", {"standard", "fej"}},
                                          {"window.iterations", {"1", "5"}},
                                          {"window.solver", {"own", "ceres"}}};
  const auto& own = estimator == "window" ? of_windows : of_filters;
  options.insert(options.end(), own.begin(), own.end());
  return options;
}

// What a run leaves: every number of its cameras, as bits, or why it was refused.
struct Outcome {
  std::vector<double> numbers;
  InForce in_force;
  std::string refused;
  bool diverged = false;
};

class InForcePairs : public testing::TestWithParam<std::string> {
 protected:
  const Outcome& run(const Settings& settings) {
    const auto known = outcomes_.find(settings);
    if (known != outcomes_.end()) return known->second;
    Configuration c;
    assign(c, {"window.frames", "3"});
    for (const auto& [key, value] : settings) assign(c, {key, value});
    Outcome& outcome = outcomes_[settings];
    try {
      const RunResult run = run_estimator(sequence_, c, GetParam());
      for (const CameraEstimate& camera : run.filtered) {
        const auto add = [&](const auto& m) {
          outcome.numbers.insert(outcome.numbers.end(), m.data(), m.data() + m.size());
        };
        add(camera.state.position);
        add(camera.covariance);
      }
      outcome.in_force = *run.in_force;
      outcome.diverged = static_cast<bool>(run.diverged);
    } catch (const std::invalid_argument& error) {
      outcome.refused = error.what();
    }
    return outcome;
  }

  struct Stated {
    bool is_stated = false, is_on = false;
    long acted = 0;
  };

  // Of all mechanisms of this key.
  static Stated stated(const Outcome& outcome, const std::string& key) {
    Stated result;
    for (const Mechanism& m : outcome.in_force) {
      if (m.key != key) continue;
      result.is_stated = true;
      result.is_on |= m.is_on;
      result.acted += m.acted;
    }
    return result;
  }

  void judge(const Settings& settings, const Option& option, const std::string& value) {
    const Outcome& outcome = run(settings);
    if (!outcome.refused.empty()) {
      EXPECT_EQ(outcome.refused.find('\n'), std::string::npos);
      return;
    }
    const bool is_other = kOtherChoices.contains(option.key + "=" + value);
    const Stated said = is_other ? Stated{} : stated(outcome, option.key);
    if (value == option.values.front()) {
      EXPECT_FALSE(said.is_on);
      return;
    }
    Settings off = settings;
    off[option.key] = option.values.front();
    // A run that has ended does not say what would have acted in its later frames.
    if (outcome.diverged || run(off).diverged) return;
    const bool differs = run(off).numbers != outcome.numbers;
    const bool acted = !said.is_stated || (said.is_on && said.acted > 0);
    EXPECT_EQ(differs, acted) << (said.is_stated ? "stated" : "stated nowhere");
  }

  static std::string text(const Settings& settings) {
    std::string text;
    for (const auto& [key, value] : settings) text += " " + key + "=" + value;
    return text;
  }

  const Sequence sequence_ = simulate("circle",
                                      {{"frames", GetParam() == "ekf" ? "30" : "20"},
                                       {"static", GetParam() == "ekf" ? "150" : "100"},
                                       {"moving", GetParam() == "ekf" ? "150" : "60"},
                                       {"first_moving", "3"}},
                                      3);
  std::map<Settings, Outcome> outcomes_;
};

// All other options are off, or as by default.
TEST_P(InForcePairs, WhatIsStatedIsWhatActs) {
  const std::vector<Option> options = options_of(GetParam());
  Settings off;
  for (const Option& option : options) off[option.key] = option.values.front();
  for (std::size_t a = 0; a < options.size(); ++a) {
    for (std::size_t b = a + 1; b < options.size(); ++b) {
      for (const std::string& x : options[a].values) {
        for (const std::string& y : options[b].values) {
          Settings settings = off;
          settings[options[a].key] = x;
          settings[options[b].key] = y;
          SCOPED_TRACE(GetParam() + text(settings));
          judge(settings, options[a], x);
          judge(settings, options[b], y);
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Families, InForcePairs, testing::Values("ekf", "window"),
                         [](const auto& family) { return family.param; });

}  // namespace
}  // namespace slammot
