// Figures that stay, whatever is made faster: the EKF's from before the work on speed (commit
// c6c1f48), the window's of commit 9b77407, in which pruned landmarks leave it whole (before, paths
// differed by 1e-5 of their length). With the defaults of the first, to which those that have
// changed are set back. Other processors round otherwise, which 200 frames carry to about 1e-11; a
// changed result is 1e-9 away.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "datasets/text/text_table.h"
#include "eval/run/run.h"
#include "tests/paths.h"

namespace slammot {
namespace {

using Vector21d = Eigen::Matrix<double, 21, 1>;

struct GoldenFrame {
  int frame = 0;
  CameraState pose;
  Vector21d covariance;
};

std::vector<GoldenFrame> read_golden(const std::string& name) {
  const std::filesystem::path file =
      std::filesystem::path(test::kSourceDir) / "tests/golden" / ("circle_" + name + ".csv");
  const std::string text = read_text_file(file);
  std::vector<GoldenFrame> golden;
  TextTable table(file, text);
  table.expect_header(
      {{"# circle, seed 1: pose (x y z qx qy qz qw) and the upper triangle of its "
        "covariance, by frame;"}});
  constexpr std::string_view kPrinted[] = {
      "# printed by the program of commit c6c1f48, before the work on speed began",
      "# printed by the program of commit 9b77407, after 20 iterations"};
  table.expect_header(kPrinted);
  while (table.next_comma_row(29)) {
    GoldenFrame row;
    row.frame = table.count(0);
    row.pose.position = {table.real(1), table.real(2), table.real(3)};
    row.pose.orientation = {table.real(7), table.real(4), table.real(5), table.real(6)};
    for (int k = 0; k < 21; ++k) row.covariance(k) = table.real(static_cast<std::size_t>(8 + k));
    golden.push_back(row);
  }
  return golden;
}

Vector21d upper_triangle(const Matrix12d& P) {
  Vector21d values;
  int k = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) values(k++) = P(i, j);
  }
  return values;
}

using Case = std::tuple<std::string, std::string>;

class Golden : public testing::TestWithParam<Case> {};

TEST_P(Golden, FiguresStay) {
  constexpr double kSame = 1e-9;
  const auto& [estimator, landmark] = GetParam();
  const std::vector<GoldenFrame> golden = read_golden(estimator + "_" + landmark);
  ASSERT_FALSE(golden.empty());
  Configuration configuration;
  configuration.model.landmark = landmark;
  configuration.model.labels.rule = LabelRule::kOneWay;
  configuration.model.labels.births = Births::kStaticFirst;
  configuration.model.collapse = Collapse::kDrop;
  configuration.model.depth_prior = DepthPriorSource::kFixed;
  configuration.model.classifier.name = "thesis";
  configuration.model.gate.given_others = 1.0;
  configuration.model.policy.movers = Movers::kJoint;
  configuration.model.gauge = Gauge::kNone;
  configuration.ekf.second_order = false;
  configuration.window.frames = 10;
  configuration.window.linearisation_error = 0.0;  // all iterations
  const Sequence sequence =
      select_frames(simulate("circle", {{"first_moving", "0"}}, 1), 0, golden.back().frame, 1);
  const RunResult run = run_estimator(sequence, configuration, estimator);
  ASSERT_EQ(run.filtered.size(), sequence.frames.size());
  double worst_pose = 0.0, worst_covariance = 0.0;
  for (const GoldenFrame& g : golden) {
    const CameraEstimate& now = run.filtered[static_cast<std::size_t>(g.frame)];
    ASSERT_TRUE(now.covariance.allFinite() && now.state.position.allFinite());
    worst_pose = std::max({worst_pose,
                           (now.state.position - g.pose.position).norm() / g.pose.position.norm(),
                           now.state.orientation.angularDistance(g.pose.orientation)});
    const double difference = (upper_triangle(now.covariance) - g.covariance).norm();
    worst_covariance = std::max(worst_covariance, difference / g.covariance.norm());
  }
  std::printf("largest relative difference: pose %.1e, covariance %.1e\n", worst_pose,
              worst_covariance);
  EXPECT_LT(worst_pose, kSame);
  EXPECT_LT(worst_covariance, kSame);
}

INSTANTIATE_TEST_SUITE_P(
    Estimators, Golden,
    testing::Combine(testing::Values("ekf", "window"),
                     testing::Values("scaled_velocity", "dynamic_inverse_depth")),
    [](const auto& c) { return std::get<0>(c.param) + "_" + std::get<1>(c.param); });

}  // namespace
}  // namespace slammot
