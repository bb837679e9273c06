// A camera that moves more than was stated of it: EKF and window widen its noise alike. When:
// estimation/test_frame_loop.cpp and test_camera_noise.cpp; what it does to runs:
// eval/studies/jolts.yaml, and with wrong matches hostile.yaml.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"
#include "smoothers/window/window.h"

namespace slammot {
namespace {

std::unique_ptr<Belief> made(const std::string& family, const slammot::Setup& setup) {
  if (family == "ekf") return std::make_unique<Ekf>(setup, ModelOptions{}, EkfOptions{});
  return std::make_unique<Window>(setup, ModelOptions{}, WindowOptions{});
}

// Two frames of `circle` with every landmark static; the second step's noise is as told, and then
// widened.
struct Second {
  Eigen::MatrixXd HPHt;
  CameraEstimate camera;
};
Second second_frame(const std::string& family, double told, const std::vector<double>& widened) {
  const Sequence sequence = simulate("circle", {{"moving", "0"}}, 3);
  const slammot::Setup setup = make_setup(sequence, Configuration{});
  const auto belief = made(family, setup);
  const Frame &first = sequence.frames[0], &second = sequence.frames[1];
  TrackRecords records;
  belief->predict(first, 0.0, setup.camera_noise, records);
  for (const Observation& z : first.observations) {
    records[z.track].label = Label::kStatic;
    EXPECT_TRUE(belief->add(first_pixel(z, setup.prior), setup.prior, false));
  }
  belief->finish();
  belief->predict(second, second.timestamp - first.timestamp, scaled(setup.camera_noise, told),
                  records);
  std::vector<Observation> measured;
  for (const Observation& z : second.observations) {
    if (records.contains(z.track)) measured.push_back(z);
  }
  FrameInnovation innovation;
  belief->innovations(measured, innovation);
  for (const double factor : widened) {
    belief->widen(factor);
    belief->innovations(measured, innovation);
  }
  const Eigen::MatrixXd HPHt = (*innovation.HPHt).selfadjointView<Eigen::Lower>();
  NoStages stages;
  belief->update(innovation.z, {}, stages);
  return {HPHt, belief->camera()};
}

class Jolt : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Families, Jolt, testing::Values("ekf", "window"),
                         [](const auto& family) { return family.param; });

void expect_same(const Second& a, const Second& b) {
  EXPECT_LT((a.HPHt - b.HPHt).norm(), 1e-9 * b.HPHt.norm());
  EXPECT_LT(boxminus(a.camera.state, b.camera.state).norm(), 1e-9);
  EXPECT_LT((a.camera.covariance - b.camera.covariance).norm(), 1e-9 * b.camera.covariance.norm());
}

TEST_P(Jolt, AStepWidenedAfterwardsIsThatOfAWiderNoise) {
  const Second told = second_frame(GetParam(), 49.0, {});
  const Second as_stated = second_frame(GetParam(), 1.0, {});
  EXPECT_GT((as_stated.HPHt - told.HPHt).norm(), 0.01 * told.HPHt.norm());
  expect_same(second_frame(GetParam(), 1.0, {49.0}), told);
  expect_same(second_frame(GetParam(), 1.0, {49.0, 1.0 / 49.0}), as_stated);
}

// The batch takes each step's noise from the window in front of it.
TEST(JoltInTheWindow, TellsTheBatchOfAWidenedStep) {
  const Sequence sequence = simulate("circle", {{"frames", "3"}}, 3);
  const slammot::Setup setup = make_setup(sequence, Configuration{});
  TrackHistories histories;
  Window window(setup, ModelOptions{}, WindowOptions{}, &histories);
  window.predict(sequence.frames[0], 0.0, setup.camera_noise, {});
  window.finish();
  window.predict(sequence.frames[1], 0.1, setup.camera_noise, {});
  window.widen(49.0);
  ASSERT_EQ(window.camera_noises().size(), 1u);
  const MotionNoise &told = window.camera_noises().front(), &stated = setup.camera_noise;
  EXPECT_DOUBLE_EQ(told.acceleration, 7.0 * stated.acceleration);
  EXPECT_DOUBLE_EQ(told.angular_acceleration, 7.0 * stated.angular_acceleration);
  window.widen(1.0 / 49.0);
  EXPECT_DOUBLE_EQ(told.acceleration, stated.acceleration);
}

}  // namespace
}  // namespace slammot
