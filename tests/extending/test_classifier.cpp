// A classifier, as docs/extending.md adds one: what stands between the `example` and `end` lines is
// quoted there, and that it compiles is half the test.
#include <gtest/gtest.h>

#include "estimation/classification.h"

namespace slammot {
namespace {

// [example: classifier]
// Static below a speed, moving above it, once two standard deviations say which.
class SpeedClassifier final : public Classifier {
 public:
  explicit SpeedClassifier(double speed) : speed_(speed) {}

  Label decide(const MotionBelief& belief) const override {
    const double w_per_v = std::cbrt(belief.density_scale);  // w = v, or w = rho v
    const double speed = belief.velocity_part().norm() / w_per_v;
    const double margin = 2.0 * std::sqrt(belief.velocity_covariance().trace()) / w_per_v;
    if (speed + margin < speed_) return Label::kStatic;
    return speed - margin > speed_ ? Label::kMoving : Label::kUnknown;
  }

 private:
  double speed_;  // [m/s]
};
// [end]

TEST(ExtendingClassifier, DecidesThroughItsInterface) {
  const std::unique_ptr<Classifier> classifier = std::make_unique<SpeedClassifier>(0.3);
  MotionBelief belief;
  belief.w = Eigen::Vector3d(0.1, 0.0, 0.0);
  belief.covariance = Eigen::Matrix3d::Identity();
  EXPECT_EQ(classifier->decide(belief), Label::kUnknown);
  belief.covariance *= 1e-4;
  EXPECT_EQ(classifier->decide(belief), Label::kStatic);
  belief.w(0) = 1.0;
  EXPECT_EQ(classifier->decide(belief), Label::kMoving);
  // The same point in scaled velocity, at rho = 0.2: u = rho v.
  belief.w *= 0.2;
  belief.covariance *= 0.04;
  belief.density_scale = 0.008;
  EXPECT_EQ(classifier->decide(belief), Label::kMoving);
  EXPECT_EQ(classifier->at_birth(7), Label::kUnknown);
}

}  // namespace
}  // namespace slammot
