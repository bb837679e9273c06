// The camera's noise that follows a curve: a Kalman filter of the velocity alone, measured in every
// frame, whose accelerations are as stated or all of one sign.
#include "estimation/modules/camera_noise.h"

#include <gtest/gtest.h>

#include <random>

namespace slammot {
namespace {

constexpr double kDt = 0.1;
constexpr MotionNoise kStated{0.5, 0.2};  // [m/s^2], [rad/s^2]

// Both velocities, each axis on its own. Accelerations are in units of sigma; the measurement's
// error in what sigma lets the velocity change by in kDt.
class Filter {
 public:
  explicit Filter(double error) : error_(error), noise_(kStated, true) {
    camera_.covariance.diagonal().tail<6>().setConstant(0.04);
  }

  // One frame, `dt` later, with these accelerations.
  void step(const Vector6d& acceleration, double dt = kDt, bool is_measured = true) {
    truth_ += dt * sigmas().cwiseProduct(acceleration);
    const CameraEstimate before = camera_;
    const MotionNoise& noise = noise_.of_next();
    for (int i = 0; i < 6; ++i) {
      double& x = i < 3 ? camera_.state.velocity(i) : camera_.state.angular_velocity(i - 3);
      double& P = camera_.covariance(kVelocity + i, kVelocity + i);
      const double sigma = dt * (i < 3 ? noise.acceleration : noise.angular_acceleration);
      P += sigma * sigma;
      if (!is_measured) continue;
      const double measured = error_ * kDt * sigmas()(i);
      const double gain = P / (P + measured * measured);
      x += gain * (truth_(i) + measured * normal_(random_) - x);
      P *= 1.0 - gain;
    }
    noise_.learn(before, camera_, dt);
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
  static double square(double x) { return x * x; }
  static Vector6d sigmas() {
    Vector6d s;
    s << Eigen::Vector3d::Constant(kStated.acceleration),
        Eigen::Vector3d::Constant(kStated.angular_acceleration);
    return s;
  }

  double error_;
  AdaptiveCameraNoise noise_;
  CameraEstimate camera_;
  Vector6d truth_ = Vector6d::Zero();
  std::mt19937_64 random_{7};
  std::normal_distribution<double> normal_;
};

// The means of both over many steps of noise as stated; `dt` of each step by its number.
template <typename Dt>
Eigen::Vector2d mean_factors(double error, Dt dt) {
  Filter filter(error);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    filter.step(filter.random(), dt(i));
    EXPECT_GE(std::min(filter.linear(), filter.angular()), 1.0);
    mean += Eigen::Vector2d(filter.linear(), filter.angular()) / kSteps;
  }
  return mean;
}

// |u|^2 / V is then chi-square(3) over 3, whose mean is 1, and 1.31 where no value below 1 counts.
// A velocity that is hardly measured has a covariance that grows after wide or long steps. That is
// not counted, so that the factor is a little less where steps are uneven.
TEST(AdaptiveCameraNoise, HardlyWidensNoiseThatIsRight) {
  const auto even = [](int) { return kDt; };
  const auto uneven = [](int i) { return i % 2 == 0 ? 0.5 * kDt : 2.0 * kDt; };
  for (const double error : {0.4, 2.0, 10.0}) {
    SCOPED_TRACE(error);
    for (const Eigen::Vector2d& mean : {mean_factors(error, even), mean_factors(error, uneven)}) {
      EXPECT_GT(mean.minCoeff(), 1.1);
      EXPECT_LT(mean.maxCoeff(), 1.45);
    }
  }
}

const Vector6d kForward = (Vector6d() << 1, 1, 1, 0, 0, 0).finished();
const Vector6d kTurn = (Vector6d() << 0, 0, 0, 1, 1, 1).finished();

// An acceleration of one sigma in each axis goes on: u tends to it, and V to a / (2 - a) of its
// square, so that the variance is 19 times the stated one. After the curve it is forgotten.
TEST(AdaptiveCameraNoise, WidensInACurveAndForgetsIt) {
  Filter filter(0.2);
  filter.steps(60, kForward);
  EXPECT_NEAR(filter.linear(), 19.0, 2.0);
  EXPECT_LT(filter.angular(), 2.5);  // not what turns
  filter.steps(60, Vector6d::Zero());
  EXPECT_LT(filter.linear(), 1.5);
  filter.steps(60, kTurn);
  EXPECT_NEAR(filter.angular(), 19.0, 2.0);
  EXPECT_LT(filter.linear(), 2.5);
  for (int i = 0; i < 40; ++i) filter.step(Vector6d::Zero(), kDt, false);  // nothing is measured
  EXPECT_LT(filter.angular(), 1.5);
}

// What the update has learnt of the velocity is no acceleration.
TEST(AdaptiveCameraNoise, TellsALearntVelocityFromACurve) {
  AdaptiveCameraNoise noise(kStated, true);
  CameraEstimate before, after;
  before.covariance.diagonal().tail<6>().setConstant(0.25);
  after.covariance.diagonal().tail<6>().setConstant(0.01);
  after.state.velocity = {0.5, -0.5, 0.4};  // one sigma of what it did not know
  noise.learn(before, after, kDt);
  EXPECT_LT(noise.of_next().acceleration, 1.2 * kStated.acceleration);
  // The same change of what was known is one.
  before.covariance = after.covariance;
  AdaptiveCameraNoise other(kStated, true);
  other.learn(before, after, kDt);
  EXPECT_GT(other.of_next().acceleration, 5.0 * kStated.acceleration);
}

double factor(const AdaptiveCameraNoise& noise) {
  EXPECT_NEAR(noise.of_next().acceleration / kStated.acceleration,
              noise.of_next().angular_acceleration / kStated.angular_acceleration, 1e-12);
  const double sigmas = noise.of_next().acceleration / kStated.acceleration;
  return sigmas * sigmas;
}

// A camera at rest, whose velocity says nothing.
void learn_at_rest(AdaptiveCameraNoise& noise) { noise.learn({}, {}, kDt); }

// The camera's motion is all of S, and has nine times the stated variance.
TEST(AdaptiveCameraNoise, LearnsFromMeasurementsAndForgets) {
  AdaptiveCameraNoise noise(kStated, true);
  for (int k = 0; k < 100; ++k) {
    noise.note(2.0 * 9.0 / factor(noise));
    learn_at_rest(noise);
  }
  EXPECT_NEAR(factor(noise), 9.0, 0.1);
  for (int k = 0; k < 60; ++k) {
    noise.note(0.2);
    learn_at_rest(noise);
  }
  EXPECT_EQ(factor(noise), 1.0);  // never less
}

TEST(AdaptiveCameraNoise, AJoltIsOfItsOwnStepAndLearntInPart) {
  EXPECT_EQ(AdaptiveCameraNoise::jolt(13.7), 1.0);
  EXPECT_EQ(AdaptiveCameraNoise::jolt(1e6), 5e5);
  AdaptiveCameraNoise noise(kStated, true);
  noise.note(1e6);
  learn_at_rest(noise);
  EXPECT_NEAR(factor(noise), 0.9 + 0.1 * 6.9, 1e-9);
}

}  // namespace
}  // namespace slammot
