// A metric, as examples/extension/ adds one; its code stands there.
#include <gtest/gtest.h>

#include <fstream>

#include "eval/compare/compare.h"
#include "eval/output/metrics_json.h"
#include "eval/python/report_generator.h"
#include "eval/run/process.h"
#include "eval/study/study_driver.h"
#include "eval/study/study_plan.h"
#include "examples/extension/path_ratio.h"
#include "tests/temporary_folder.h"

namespace slammot {
namespace {

const char* const kStudy =
    "format: slammot-study-1\nname: path\nruns: 2\n"
    "scenarios: [{scenario: helix, set: {frames: 12}}]\n"
    "estimators: [{estimator: ekf}, {estimator: window, set: {window.frames: 3}}]\n";

class ExtendingMetric : public testing::Test {
 protected:
  static void SetUpTestSuite() { prepare_process(); }
  const MetricTable table_ = metric_table_with({kPathRatio});
  const test::TemporaryFolder folder_;
};

TEST_F(ExtendingMetric, IsInMetricsJsonOnTheTerminalAndOnThePage) {
  const Sequence sequence = simulate("helix", {{"frames", "12"}}, 1);
  CompareOptions options;
  options.output = folder_.path();
  options.metrics = table_;
  const auto results =
      compare(sequence, {}, crossed({"ekf", "window"}, {"scaled_velocity"}), options);
  for (const NamedMetrics& result : results) {
    const double value = value_of(result.metrics.filtered.values, "path_ratio");
    EXPECT_NEAR(value, 1.0, 0.5);
    const Json file = Json::parse(test::read_text(folder_.path() / result.label / "metrics.json"));
    EXPECT_EQ(file["filtered"]["path_ratio"], value);
    EXPECT_EQ(file["smoothed"].is_null(), !result.metrics.smoothed.has_value());
    if (result.metrics.smoothed) {
      EXPECT_TRUE(file["smoothed"]["path_ratio"].is_number());
    }
  }
  EXPECT_NE(metrics_table(results).find("path ratio"), std::string::npos);
  ASSERT_EQ(make_compare_page(folder_.path()), 0);
  const std::string page = test::read_text(folder_.path() / "report.html");
  EXPECT_NE(page.find("title=\"estimated over true length of the path\">path ratio"),
            std::string::npos);
}

TEST_F(ExtendingMetric, IsPooledByAStudyAndAColumnOfItsTables) {
  test::write_text(folder_.path() / "path.yaml", kStudy);
  Study study = read_study(folder_.path() / "path.yaml");
  study.metrics = table_;
  StudyOptions options;
  options.output = folder_.path() / "study";
  claim_folder(study, options.output, options.shard, false);
  ASSERT_EQ(run_study(study, options), 4);
  merge_runs(study, {options.output}, options.output, false);
  std::ofstream(options.output / "plan.json") << study_plan(study).dump(1) << '\n';
  ASSERT_EQ(make_study_page(options.output), 0);
  const Json summary = Json::parse(test::read_text(options.output / "summary.json"));

  std::ifstream results(options.output / "results.jsonl");
  std::string first, second;
  std::getline(results, first);
  std::getline(results, second);
  const double a = Json::parse(first)["filtered"]["path_ratio"].get<double>();
  const double b = Json::parse(second)["filtered"]["path_ratio"].get<double>();
  const Json& cells = summary["groups"][0]["cells"];
  EXPECT_DOUBLE_EQ(cells[0]["filtered_path_ratio"]["value"].get<double>(), 0.5 * (a + b));
  EXPECT_EQ(cells[1]["smoothed_path_ratio"]["runs"], 2);

  const std::string csv = test::read_text(options.output / "tables" / "metrics.csv");
  const std::string head = csv.substr(0, csv.find('\n'));
  EXPECT_NE(head.find(",path ratio"), std::string::npos) << head;
  EXPECT_NE(head.find(",smoothed: path ratio"), std::string::npos) << head;
}

}  // namespace
}  // namespace slammot
