// A covariance that is surer of the scale than what was stated of it.
#include "eval/run/scale_check.h"

#include <gmock/gmock.h>

#include "datasets/simulation/scenario.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

Setup with_first_velocity() {
  slammot::Setup setup;
  setup.prior.inverse_depth = 0.3;
  setup.prior.mean_sigma = 1.0;
  setup.initial.state.velocity = {0.0, 0.3, 0.4};
  setup.initial.velocity_sigma = 0.1;
  setup.camera_noise.acceleration = 2.0;
  return setup;
}

TEST(ScaleCheck, FirstVelocityAndMeanDepthTellTheScale) {
  const auto setup = with_first_velocity();
  EXPECT_NEAR(stated_scale(setup)->information, 25.0 + 0.09, 1e-12);
  EXPECT_EQ(stated_scale(setup)->acceleration, 2.0);
  slammot::Setup other = setup;
  other.known.emplace_back();
  EXPECT_FALSE(stated_scale(other));
  other = setup;
  other.prior.mean_sigma = 0.0;  // depths are known on average
  EXPECT_FALSE(stated_scale(other));
  other = setup;
  other.initial.velocity_sigma = 0.3;  // speed 0.5: nothing tells it
  EXPECT_FALSE(stated_scale(other));
}

// A camera that goes on and on in one direction from somewhere; its way is uncertain by `share` of
// itself, and by a metre across.
const Eigen::Vector3d kAhead = Eigen::Vector3d(2.0, -1.0, 2.0) / 3.0;
constexpr int kLength = 20;
constexpr StatedScale kStated{.information = 100.0, .acceleration = 1.0};  // to 10%

CameraEstimate gone(int frame, double share) {
  const double way = 0.5 * frame;
  CameraEstimate camera;
  camera.timestamp = frame;
  camera.state.position = Eigen::Vector3d(5.0, 6.0, 7.0) + way * kAhead;
  camera.state.velocity = 0.5 * kAhead;
  const Eigen::Matrix3d along = kAhead * kAhead.transpose();
  camera.covariance.setIdentity();
  camera.covariance.block<3, 3>(kPosition, kPosition) =
      std::pow(share * way, 2) * along + Eigen::Matrix3d::Identity() - along;
  return camera;
}

RunResult straight(double share) {
  RunResult run;
  for (int i = 0; i < kLength; ++i) {
    run.frames.push_back(100 + i);
    run.filtered.push_back(gone(i, share));
  }
  return run;
}

TEST(ScaleCheck, WarnsOfLessThanAThird) {
  EXPECT_FALSE(scale_warning(straight(0.1), kStated));
  EXPECT_FALSE(scale_warning(straight(0.034), kStated));
  const auto warning = scale_warning(straight(0.033), kStated);
  ASSERT_TRUE(warning);
  EXPECT_EQ(warning->frame, 101);
  EXPECT_THAT(warning->reason, HasSubstr("to 3.3%"));
  EXPECT_THAT(warning->reason, HasSubstr("only to 10%"));
}

TEST(ScaleCheck, TheFirstFrameThatIsTooSure) {
  RunResult run = straight(0.1);
  run.filtered[10].covariance.setConstant(kUndefined);
  for (int i = 15; i < kLength; ++i) run.filtered[static_cast<std::size_t>(i)] = gone(i, 0.01);
  const auto warning = scale_warning(run, kStated);
  ASSERT_TRUE(warning);
  EXPECT_EQ(warning->frame, 115);
  EXPECT_THAT(warning->reason, HasSubstr("to 1%"));
}

// Of a velocity that changes by its sigma in each axis: 3 in each frame, 100 + 3 * 19 in all. What
// changes by more is lost, and tells no more.
TEST(ScaleCheck, AccelerationsTellTheScale) {
  RunResult run = straight(0.1);
  run.filtered.back() = gone(kLength - 1, 0.0316);
  EXPECT_TRUE(scale_warning(run, kStated));
  for (const double speed : {1.0, 1000.0}) {
    for (std::size_t i = 1; i < run.filtered.size(); i += 2) {
      run.filtered[i].state.velocity = speed * Eigen::Vector3d::Ones();
      run.filtered[i - 1].state.velocity.setZero();
    }
    EXPECT_FALSE(scale_warning(run, kStated));
    run.filtered.back().covariance *= 0.5;
    EXPECT_TRUE(scale_warning(run, kStated));  // 2.2% for 8%
    run.filtered.back().covariance *= 2.0;
  }
}

TEST(ScaleCheck, OfABatchItsSmoothedPoses) {
  RunResult run = straight(0.1);
  run.batch = true;
  run.smoothed = straight(0.01).filtered;
  EXPECT_TRUE(scale_warning(run, kStated));
  std::swap(run.smoothed, run.filtered);
  EXPECT_FALSE(scale_warning(run, kStated));
}

TEST(ScaleCheck, WhatIsNotStatedOrHasNotMovedIsNoReason) {
  RunResult run = straight(0.01);
  for (CameraEstimate& camera : run.filtered) camera.covariance.setConstant(kUndefined);
  EXPECT_FALSE(scale_warning(run, kStated));
  for (CameraEstimate& camera : run.filtered) camera.covariance.setZero();
  EXPECT_FALSE(scale_warning(run, kStated));
  run = straight(0.01);
  for (CameraEstimate& camera : run.filtered) camera.state.position = {1.0, 2.0, 3.0};
  EXPECT_FALSE(scale_warning(run, kStated));
}

RunResult without_known(const std::string& estimator, bool keeps_scale = true) {
  const Sequence sequence = simulate("circle", {{"known", "0"}, {"frames", "60"}}, 9001);
  Configuration configuration;
  configuration.prior.mean_sigma = 1.0;
  configuration.window.frames = 60;
  configuration.model.gauge = keeps_scale ? Gauge::kScale : Gauge::kNone;
  return run_estimator(sequence, configuration, estimator);
}

// While a window holds all frames, its covariance has the scale as it was stated. A filter becomes
// sure of a wrong one, unless its updates keep what is known of it.
TEST(ScaleCheck, AFilterIsTooSureAndAWindowOfAllFramesIsNot) {
  const auto of_scale = Contains(Field(&RunWarning::reason, HasSubstr("the scale")));
  EXPECT_THAT(without_known("ekf", false).warnings, of_scale);
  EXPECT_THAT(without_known("ekf").warnings, Not(of_scale));
  const RunResult window = without_known("window");
  EXPECT_THAT(window.warnings, Not(of_scale));
  EXPECT_TRUE(window.filtered.back().covariance.allFinite());
}

}  // namespace
}  // namespace slammot
