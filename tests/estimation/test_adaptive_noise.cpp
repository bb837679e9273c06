// The camera's noise that follows a curve: a Kalman filter of the velocity alone, measured in every
// frame, whose accelerations are as stated or all of one sign.
#include "estimation/loop/adaptive_noise.h"

#include <gtest/gtest.h>

#include <random>

namespace slammot {
namespace {

constexpr double kDt = 0.1;
constexpr MotionNoise kStated{0.5, 0.2};  // [m/s^2], [rad/s^2]

// Both velocities, each axis with an information of its own; the acceleration in units of sigma.
class Filter {
 public:
  explicit Filter(bool adapts = true) : noise_(kStated, adapts) {
    camera_.covariance.diagonal().tail<6>().setConstant(0.04);
  }

  // One frame with these accelerations.
  void step(const Vector6d& acceleration) {
    truth_ += kDt * sigmas().cwiseProduct(acceleration);
    const CameraEstimate before = camera_;
    const MotionNoise& noise = noise_.of_next();
    for (int i = 0; i < 6; ++i) {
      double& x = i < 3 ? camera_.state.velocity(i) : camera_.state.angular_velocity(i - 3);
      double& P = camera_.covariance(kVelocity + i, kVelocity + i);
      const double sigma = kDt * (i < 3 ? noise.acceleration : noise.angular_acceleration);
      P += sigma * sigma;
      const double gain = P / (P + kMeasured * kMeasured);
      x += gain * (truth_(i) + kMeasured * normal_(random_) - x);
      P *= 1.0 - gain;
    }
    if (noise_.adapts()) noise_.learn(before, camera_, kDt);
  }

  void steps(int count, const Vector6d& acceleration) {
    for (int i = 0; i < count; ++i) step(acceleration);
  }
  Vector6d random() {
    return Vector6d::NullaryExpr([&] { return normal_(random_); });
  }

  // Its variances over the stated ones.
  double linear() const { return square(noise_.of_next().acceleration / kStated.acceleration); }
  double angular() const {
    return square(noise_.of_next().angular_acceleration / kStated.angular_acceleration);
  }

 private:
  static constexpr double kMeasured = 0.02;
  static double square(double x) { return x * x; }
  static Vector6d sigmas() {
    Vector6d s;
    s << Eigen::Vector3d::Constant(kStated.acceleration),
        Eigen::Vector3d::Constant(kStated.angular_acceleration);
    return s;
  }

  AdaptiveNoise noise_;
  CameraEstimate camera_;
  Vector6d truth_ = Vector6d::Zero();
  std::mt19937_64 random_{7};
  std::normal_distribution<double> normal_;
};

// |u|^2 / V is then chi-square(3) over 3, whose mean is 1, and 1.31 where no value below 1 counts.
TEST(AdaptiveNoise, HardlyWidensNoiseThatIsRight) {
  Filter filter;
  double linear = 0.0, angular = 0.0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    filter.step(filter.random());
    EXPECT_GE(filter.linear(), 1.0);
    linear += filter.linear() / kSteps;
    angular += filter.angular() / kSteps;
  }
  EXPECT_NEAR(linear, 1.31, 0.1);
  EXPECT_NEAR(angular, 1.31, 0.1);
}

// An acceleration of one sigma in each axis goes on: u tends to it, and V to a / (2 - a) of its
// square, so that the variance is 19 times the stated one. After the curve it is forgotten.
TEST(AdaptiveNoise, WidensInACurveAndForgetsIt) {
  Filter filter;
  const Vector6d forward = (Vector6d() << 1, 1, 1, 0, 0, 0).finished();
  filter.steps(30, forward);
  EXPECT_GT(filter.linear(), 12.0);
  EXPECT_LT(filter.linear(), 22.0);
  EXPECT_LT(filter.angular(), 2.5);  // not what turns
  filter.steps(60, Vector6d::Zero());
  EXPECT_LT(filter.linear(), 1.5);
  filter.steps(30, (Vector6d() << 0, 0, 0, 1, 1, 1).finished());
  EXPECT_GT(filter.angular(), 12.0);
  EXPECT_LT(filter.linear(), 2.5);
}

// What the update has learnt of the velocity is no acceleration.
TEST(AdaptiveNoise, TellsALearntVelocityFromACurve) {
  AdaptiveNoise noise(kStated, true);
  CameraEstimate before, after;
  before.covariance.diagonal().tail<6>().setConstant(0.25);
  after.covariance.diagonal().tail<6>().setConstant(0.01);
  after.state.velocity = {0.5, -0.5, 0.4};  // one sigma of what it did not know
  noise.learn(before, after, kDt);
  EXPECT_LT(noise.of_next().acceleration, 1.2 * kStated.acceleration);
  // The same change of what was known is one.
  before.covariance = after.covariance;
  AdaptiveNoise other(kStated, true);
  other.learn(before, after, kDt);
  EXPECT_GT(other.of_next().acceleration, 5.0 * kStated.acceleration);
}

TEST(AdaptiveNoise, StaysAsStatedWhereItDoesNotAdapt) {
  Filter filter(false);
  filter.steps(30, Vector6d::Ones());
  EXPECT_EQ(filter.linear(), 1.0);
  EXPECT_EQ(filter.angular(), 1.0);
}

}  // namespace
}  // namespace slammot
