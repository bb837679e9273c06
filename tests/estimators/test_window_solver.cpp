// `window.solver: ceres` and our own solver find the same minimum in every frame, and so the same
// labels, poses and covariances.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "datasets/readers/reader.h"
#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "smoothers/window/window.h"
#include "tests/estimators/fixture/linearisation_fixture.h"
#include "tests/paths.h"

namespace slammot {
namespace {

using test::expect_same_labels;
using test::relative_difference;

std::unique_ptr<Estimator> window_with(WindowSolver solver, const Sequence& sequence,
                                       Configuration configuration) {
  configuration.window.frames = 10;
  configuration.window.linearisation_error = 0.0;  // Ceres goes on until nothing changes
  configuration.window.solver = solver;
  configuration.model.labels.births = Births::kStaticFirst;  // every frame is solved once
  return make_window(make_setup(sequence, configuration), configuration.model,
                     configuration.window);
}

// A cost is known to its rounding, and so its minimum to the root of that, in sigmas: the cost is
// d^2 / 2 above it. Ceres stops where the cost no longer changes, some of these short of the
// minimum in directions in which it converges slowly.
constexpr double kCost = 500.0;  // of a window of these tests
const double kOfRounding = 10.0 * std::sqrt(2.0 * std::numeric_limits<double>::epsilon() * kCost);

// In all frames but the first few, where depths are hardly known: both go on for as many iterations
// as they may there.
void expect_same_runs(const Sequence& sequence, const Configuration& configuration, int first_few,
                      double of_first, double bound) {
  const auto own = window_with(WindowSolver::kOwn, sequence, configuration);
  const auto ceres = window_with(WindowSolver::kCeres, sequence, configuration);
  NoStages stages;
  double worst_of_first = 0.0, worst = 0.0;  // [sigma], and relative ones of covariances
  int decided = 0;
  for (const Frame& frame : sequence.frames) {
    const FrameReport report = own->process(frame, stages);
    const FrameReport other = ceres->process(frame, stages);
    ASSERT_EQ(report.accepted, other.accepted) << "frame " << frame.index;
    expect_same_labels(report.retired, other.retired);
    const CameraEstimate x = own->camera(), y = ceres->camera();
    const Vector12d sigma = x.covariance.diagonal().cwiseSqrt();
    const Vector12d d = boxminus(y.state, x.state).cwiseQuotient(sigma);
    double& largest = frame.index < first_few ? worst_of_first : worst;
    largest = std::max(
        {largest, d.cwiseAbs().maxCoeff(), relative_difference(y.covariance, x.covariance)});
  }
  const auto landmarks = own->landmarks();
  expect_same_labels(landmarks, ceres->landmarks());
  for (const LandmarkEstimate& l : landmarks) {
    decided += l.decision_frame && !l.by_rule;
  }
  std::printf("largest difference: %.2g in the first %d frames, then %.2g\n", worst_of_first,
              first_few, worst);
  EXPECT_LE(worst_of_first, of_first);
  EXPECT_LT(worst, bound);
  EXPECT_GT(decided, 5);
}

TEST(WindowSolver, IsThatOfCeresOnCircle) {
  Configuration configuration;
  configuration.window.iterations = 200;
  expect_same_runs(simulate("circle", {{"frames", "25"}, {"first_moving", "0"}}, 2), configuration,
                   0, 0.0, 1e-6);
}

// Noises in units of the world: our own judges its steps in metres, and refuses some of the last
// ones (noise_scale.h).
TEST(WindowSolver, IsThatOfCeresWhereOnlyTheVelocityTellsTheScale) {
  Configuration configuration;
  configuration.window.iterations = 1000;
  expect_same_runs(simulate("circle", {{"frames", "14"}, {"known", "0"}, {"first_moving", "0"}}, 2),
                   configuration, 5, 2e-3, 2e-2);
}

// Its first 25 frames; the whole takes minutes.
TEST(WindowSolver, IsThatOfCeresOnARecording) {
  const std::filesystem::path folder = std::filesystem::path(test::kSharedData) / "synth19_1px";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  Configuration configuration;
  configuration.window.iterations = 1000;
  expect_same_runs(select_frames(read_sequence(folder), 0, 24, 1), configuration, 5, 1e-4,
                   kOfRounding);
}

TEST(WindowSolver, CeresNeedsTheJacobiansOfTheCost) {
  const Sequence sequence = simulate("circle", {{"frames", "2"}}, 1);
  Configuration configuration;
  configuration.window.linearisation = WindowLinearisation::kFej;
  EXPECT_THROW(window_with(WindowSolver::kCeres, sequence, configuration), std::invalid_argument);
}

}  // namespace
}  // namespace slammot
