// Comparing: one folder a run, one JSON, one table; the sequence has no observations at all.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "eval/compare/compare.h"
#include "eval/output/metrics_table.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

CompareOptions options_to(const std::filesystem::path& folder) {
  CompareOptions options;
  options.output = folder;
  options.command = "slammot compare";
  options.seed = 5;
  return options;
}

TEST(Compare, AFolderForEachRunAndOneJson) {
  const test::TemporaryFolder folder;
  const Sequence sequence = test::straight_line(5);
  const auto rows = crossed({"ekf", "static_world"}, {"scaled_velocity"});
  const auto results = compare(sequence, Configuration{}, rows, options_to(folder.path()));
  ASSERT_EQ(results.size(), 2u);
  EXPECT_FALSE(results[0].metrics.diverged);
  EXPECT_EQ(results[1].landmark, "scaled_velocity");
  const auto json = nlohmann::json::parse(test::read_text(folder.path() / "compare.json"));
  EXPECT_EQ(json["format"], "slammot-compare-1");
  EXPECT_EQ(json["sequence"]["seed"], 5);
  EXPECT_EQ(json["truth"]["position"].size(), 5u);
  EXPECT_EQ(json["truth"]["landmarks"].size(), 2u);
  ASSERT_EQ(json["runs"].size(), 2u);
  const auto& run = json["runs"][1];
  EXPECT_EQ(run["label"], "static_world-scaled_velocity");
  EXPECT_EQ(run["configuration"]["classifier"], "all_static");
  EXPECT_FALSE(run["metrics"]["filtered"]["nees"].contains("series"));
  for (const char* name : {"timestamp", "position", "position_error_m", "rotation_error_deg",
                           "nees_pose", "frame", "nis_mean", "state_size", "frame_ms"}) {
    EXPECT_EQ(run["series"][name].size(), 5u) << name;
  }
  EXPECT_TRUE(run["series"]["nees_pose"][0].is_null());  // before the first prediction
  EXPECT_TRUE(run["smoothed_series"].is_null());
  for (const auto& row : rows) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / row.label / "metrics.json"));
  }
  const std::string table = metrics_table(results);
  EXPECT_NE(table.find("static_world"), std::string::npos);
  EXPECT_NE(table.find("position RMSE m"), std::string::npos);
}

TEST(Compare, MistakesAreFoundBeforeTheFirstRun) {
  const test::TemporaryFolder folder;
  const Sequence sequence = test::straight_line(2);
  const auto output = folder.path() / "out";
  using Names = std::vector<std::string>;
  for (const auto& [estimators, landmarks] :
       {std::pair{Names{"ekf"}, Names{"scaled_velocity", "cube"}},
        std::pair{Names{"ekf", "guess"}, Names{"scaled_velocity"}},
        std::pair{Names{"ekf", "ekf"}, Names{"scaled_velocity"}}}) {
    EXPECT_THROW(
        compare(sequence, Configuration{}, crossed(estimators, landmarks), options_to(output)),
        std::invalid_argument);
    EXPECT_FALSE(std::filesystem::exists(output));
  }
}

}  // namespace
}  // namespace slammot
