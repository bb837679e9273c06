// An estimator, as docs/extending.md adds one: what stands between the `example` and `end` lines is
// named there and its row quoted, and that it compiles is half the test.
#include <gtest/gtest.h>

#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"
#include "eval/metrics/metrics.h"
#include "eval/run/run.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

// [example: estimator]
// Dead reckoning: the camera's motion model alone, no measurement is used.
class DeadReckoning final : public Estimator {
 public:
  explicit DeadReckoning(const Setup& setup) : noise_(setup.camera_noise) {
    camera_.state = setup.initial.state;
    camera_.covariance = setup.initial.sigmas().cwiseAbs2().asDiagonal();
  }

  FrameReport process(const Frame& frame, StageListener& stages) override {
    stages.begin("predict");
    if (started_) predict_to(frame.timestamp);
    started_ = true;
    camera_.timestamp = frame.timestamp;
    FrameReport report;
    report.state_size = kCameraDim;
    return report;
  }

  CameraEstimate camera() const override { return camera_; }
  std::vector<LandmarkEstimate> landmarks() const override { return {}; }

 private:
  void predict_to(double timestamp) {
    const double dt = timestamp - camera_.timestamp;
    if (!(dt > 0.0)) throw std::invalid_argument("the time of a frame must increase");
    const Matrix12d F = predict_jacobian(camera_.state, dt);
    camera_.covariance =
        F * camera_.covariance * F.transpose() + camera_noise(noise_, camera_.state, dt);
    camera_.state = predict(camera_.state, dt);
  }

  MotionNoise noise_;
  CameraEstimate camera_;
  bool started_ = false;
};

constexpr EstimatorRow kDeadReckoning{
    "dead_reckoning",
    "the motion model alone",
    EstimatorKind::kFilter,
    false,
    [](Configuration&) {},
    [](const Setup& setup, const Configuration&) -> std::unique_ptr<Estimator> {
      return std::make_unique<DeadReckoning>(setup);
    }};
// [end]

TEST(ExtendingEstimator, IsDrivenAndJudged) {
  // [example: driving]
  Sequence sequence = test::straight_line(5);  // x = 0, 1, 2, ... m, one second apart
  sequence.initial.emplace();
  sequence.initial->state.velocity = {1.0, 0.0, 0.0};

  const Configuration configuration;
  const auto setup = make_setup(sequence, configuration);
  const std::unique_ptr<Estimator> estimator = kDeadReckoning.make(setup, configuration);
  const RunResult run = drive(sequence, *estimator);
  const RunMetrics metrics = compute_metrics(sequence, run, configuration.model.gate.probability);
  // [end]
  ASSERT_FALSE(run.diverged);
  ASSERT_EQ(run.filtered.size(), 5u);
  ASSERT_TRUE(metrics.filtered.accuracy.value);
  EXPECT_LT(metrics.filtered.accuracy.value->position_rmse, 1e-12);
  EXPECT_GT(run.filtered[4].covariance(0, 0), run.filtered[3].covariance(0, 0));
}

}  // namespace
}  // namespace slammot
