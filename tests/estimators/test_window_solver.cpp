// `window.solver: ceres` and our own solver find the same minimum in every frame, and so the same
// labels, poses and covariances.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "smoothers/window/window.h"
#include "tests/estimators/fixture/linearisation_fixture.h"

namespace slammot {
namespace {

using test::relative_difference;

std::unique_ptr<Estimator> window_with(WindowSolver solver, const Sequence& sequence,
                                       Configuration configuration) {
  configuration.window.frames = 10;
  configuration.window.iterations = 100;
  configuration.window.linearisation_error = 0.0;  // Ceres goes on until nothing changes
  configuration.window.solver = solver;
  configuration.model.labels.first_frame = FirstFrameLabels::kStatic;  // every frame is solved once
  return make_window(make_setup(sequence, configuration), configuration.model,
                     configuration.window);
}

void expect_same_labels(const std::vector<LandmarkEstimate>& a,
                        const std::vector<LandmarkEstimate>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].track, b[i].track);
    ASSERT_EQ(a[i].label, b[i].label) << "track " << a[i].track;
    ASSERT_EQ(a[i].decision_frame, b[i].decision_frame) << "track " << a[i].track;
    ASSERT_EQ(a[i].observations, b[i].observations) << "track " << a[i].track;
  }
}

void expect_same_runs(const Sequence& sequence, const Configuration& configuration) {
  const auto own = window_with(WindowSolver::kOwn, sequence, configuration);
  const auto ceres = window_with(WindowSolver::kCeres, sequence, configuration);
  NoStages stages;
  double worst_state = 0.0, worst_covariance = 0.0;
  int decided = 0, same = 0;
  for (const Frame& frame : sequence.frames) {
    const FrameReport report = own->process(frame, stages);
    const FrameReport other = ceres->process(frame, stages);
    ASSERT_EQ(report.accepted, other.accepted) << "frame " << frame.index;
    expect_same_labels(report.retired, other.retired);
    const CameraEstimate x = own->camera(), y = ceres->camera();
    const Vector12d sigma = x.covariance.diagonal().cwiseSqrt();
    const Vector12d d = boxminus(y.state, x.state).cwiseQuotient(sigma);
    const double covariance = relative_difference(y.covariance, x.covariance);
    same += std::max(d.cwiseAbs().maxCoeff(), covariance) < 1e-6;
    worst_state = std::max(worst_state, d.cwiseAbs().maxCoeff());
    worst_covariance = std::max(worst_covariance, covariance);
  }
  const auto landmarks = own->landmarks();
  expect_same_labels(landmarks, ceres->landmarks());
  for (const LandmarkEstimate& l : landmarks) {
    decided += l.decision_frame && !l.by_rule;
  }
  std::printf("largest difference: state %.2g sigma, covariance %.2g; %d of %zu frames the same\n",
              worst_state, worst_covariance, same, sequence.frames.size());
  // In single frames Ceres ends early, where no step lowers the cost by more than its rounding.
  EXPECT_GE(same, 0.9 * static_cast<double>(sequence.frames.size()));
  EXPECT_LT(worst_state, 1e-5);
  EXPECT_LT(worst_covariance, 1e-5);
  EXPECT_GT(decided, 5);
}

TEST(WindowSolver, IsThatOfCeresOnCircle) {
  expect_same_runs(simulate("circle", {{"frames", "40"}, {"first_moving", "0"}}, 2),
                   Configuration{});
}

TEST(WindowSolver, CeresNeedsTheJacobiansOfTheCost) {
  const Sequence sequence = simulate("circle", {{"frames", "2"}}, 1);
  Configuration configuration;
  configuration.window.linearisation = WindowLinearisation::kFej;
  EXPECT_THROW(window_with(WindowSolver::kCeres, sequence, configuration), std::invalid_argument);
}

}  // namespace
}  // namespace slammot
