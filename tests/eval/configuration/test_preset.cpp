// The presets: what they set, and what the thesis leaves open.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <sstream>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/configuration.h"
#include "eval/configuration/preset.h"
#include "eval/configuration/setup.h"
#include "eval/study/study.h"
#include "tests/paths.h"

namespace slammot {
namespace {

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
}

// As they were typed in full before there were presets; `settings` are what a study's cell has
// more.
TEST(Preset, HasTheValuesOfTheThesis) {
  const std::string thesis =
      "labels=one_way labels.sightings=2 labels.memory=0 ekf.second_order=false gauge=none "
      "policy.movers=joint motion.adaptive=false classifier=thesis gate.given_others=1 "
      "collapse=drop prior.source=fixed prior.steady_time=0 landmark=dynamic_inverse_depth ";
  for (const auto& [name, label, settings] : std::vector<std::array<std::string, 3>>{
           {"table_4_1", "window",
            "labels.births=static_first window.frames=10 window.iterations=5 "
            "classifier.static_threshold=1.6"},
           {"table_4_1_thesis", "with a gate",
            "labels.births=static_first motion.discretisation=impulse gate.probability=0.95 "
            "policy.max_landmarks=100000 policy.max_visible=100000 policy.prune_after=100000"},
           {"fig_3_1", "ekf",
            "labels.births=static_first window.frames=10 window.iterations=5 "
            "classifier.static_threshold=1e12 classifier.moving_threshold=1e12"}}) {
    SCOPED_TRACE(name);
    Configuration typed;
    typed.preset = "thesis";
    std::istringstream words(thesis + settings);
    for (std::string word; words >> word;) assign(typed, parse_assignment(word));
    const Study study =
        parse_study(std::string(test::kSourceDir) + "/eval/studies/" + name + ".yaml");
    const auto cell = std::ranges::find(study.cells, label, &StudyCell::label);
    ASSERT_NE(cell, study.cells.end());
    EXPECT_EQ(key_values(cell->configuration), key_values(typed));
  }
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

}  // namespace
}  // namespace slammot
