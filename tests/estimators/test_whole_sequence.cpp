// A window as long as the sequence is the batch, by either solver and in every parametrisation.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "smoothers/batch.h"
#include "smoothers/window/window.h"
#include "tests/estimators/fixture/linearisation_fixture.h"

namespace slammot {
namespace {

using test::relative_difference;

void expect_the_batch(const Sequence& sequence, const slammot::Setup& setup,
                      const ModelOptions& models, const WindowOptions& whole) {
  const auto window = make_window(setup, models, whole);
  const auto batch = make_batch(setup, models, whole);
  NoStages stages;
  for (const Frame& frame : sequence.frames) {
    window->process(frame, stages);
    batch->process(frame, stages);
  }
  const auto a = window->smoothed(stages), b = batch->smoothed(stages);
  ASSERT_EQ(a.size(), sequence.frames.size());
  ASSERT_EQ(b.size(), sequence.frames.size());
  double worst_state = 0.0, worst_covariance = 0.0;
  for (std::size_t i = 1; i < a.size(); ++i) {
    const Vector12d d = boxminus(a[i].state, b[i].state);
    const Vector12d sigma = b[i].covariance.diagonal().cwiseSqrt();
    worst_state = std::max(worst_state, d.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
    worst_covariance =
        std::max(worst_covariance, relative_difference(a[i].covariance, b[i].covariance));
  }
  std::printf("largest difference: state %.2g sigma, covariance %.2g\n", worst_state,
              worst_covariance);
  EXPECT_LT(worst_state, 1e-4);
  EXPECT_LT(worst_covariance, 1e-4);
}

TEST(WholeSequenceKnown, WindowIsTheBatch) {
  const Sequence sequence = test::uneven(simulate("circle", {{"frames", "20"}}, 2));
  ModelOptions models;
  models.classifier.name = "truth";
  WindowOptions whole;
  whole.frames = 1000;
  whole.iterations = 40;
  whole.linearisation_error = 1e-10;
  for (const auto source : {DepthPriorSource::kFixed, DepthPriorSource::kEmpirical}) {
    models.depth_prior = source;
    expect_the_batch(sequence, make_setup(sequence, Configuration{}), models, whole);
  }
}

// Where only the first velocity tells the scale, and noises are in units of the world.
// Motions in metres by our own solver alone: Ceres may end with a mover beyond infinity, where its
// motion has no unit (chain_step.h), and a window slides to another scale then (0.01 sigma).
class WholeSequence : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(LandmarkModels, WholeSequence,
                         testing::Values("scaled_velocity", "dynamic_inverse_depth"),
                         [](const auto& model) { return std::string(model.param); });

TEST_P(WholeSequence, WindowIsTheBatchWhereOnlyTheVelocityTellsTheScale) {
  const Sequence sequence = simulate("circle", {{"frames", "10"}, {"known", "0"}}, 2);
  Configuration configuration;
  assign(configuration, {"prior.mean_sigma", "1"});
  assign(configuration, {"prior.spread", "relative"});
  ModelOptions models = configuration.model;
  models.landmark = GetParam();
  models.classifier.name = "truth";
  WindowOptions whole;
  whole.frames = 1000;
  whole.iterations = 200;
  whole.linearisation_error = 1e-10;
  for (const auto solver : {WindowSolver::kOwn, WindowSolver::kCeres}) {
    if (solver == WindowSolver::kCeres && models.landmark != "scaled_velocity") continue;
    whole.solver = solver;
    expect_the_batch(sequence, make_setup(sequence, configuration), models, whole);
  }
}

// Where nothing moves it is one cost in other coordinates: only the way to its minimum differs.
TEST(Batch, HasOneMinimumInEveryParametrisation) {
  const Sequence sequence = simulate("circle", {{"frames", "20"}, {"moving", "0"}}, 2);
  const slammot::Setup setup = make_setup(sequence, Configuration{});
  ModelOptions models;
  models.landmark = "inverse_depth";
  models.depth_prior = DepthPriorSource::kFixed;
  models.adaptive_motion = false;  // it follows the window's estimates on the way
  models.gate = {0.999999, 1.0};
  std::vector<CameraEstimate> first;
  for (const PointFunctions& point : point_table()) {
    SCOPED_TRACE(point.name);
    models.point = point.name;
    const auto batch = make_batch(setup, models, {});
    NoStages stages;
    int rejected = 0;
    for (const Frame& frame : sequence.frames) rejected += batch->process(frame, stages).rejected;
    EXPECT_EQ(rejected, 0);
    const std::vector<CameraEstimate> cameras = batch->smoothed(stages);
    ASSERT_EQ(cameras.size(), sequence.frames.size());
    if (first.empty()) first = cameras;
    double worst = 0.0;
    for (std::size_t i = 1; i < cameras.size(); ++i) {
      const Vector12d d = boxminus(cameras[i].state, first[i].state);
      const Vector12d sigma = first[i].covariance.diagonal().cwiseSqrt();
      worst = std::max(worst, d.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
    }
    std::printf("%s: largest difference %.2g sigma\n", std::string(point.name).c_str(), worst);
    EXPECT_LT(worst, 1e-3);
  }
}

}  // namespace
}  // namespace slammot
