// A classifier with one number of its own.
#pragma once

#include <slammot/estimation/classification.h>

namespace slammot {

// Static below a speed, moving above it, once two standard deviations say which.
class SpeedClassifier final : public Classifier {
 public:
  explicit SpeedClassifier(double speed) : speed_(speed) {}

  Label decide(const MotionBelief& belief, ClassifierMemory& /*memory*/) const override {
    const double w_per_v = std::cbrt(belief.density_scale);  // w = v, or w = rho v
    const double speed = belief.velocity_part().norm() / w_per_v;
    const double margin = 2.0 * std::sqrt(belief.velocity_covariance().trace()) / w_per_v;
    if (speed + margin < speed_) return Label::kStatic;
    return speed - margin > speed_ ? Label::kMoving : Label::kUnknown;
  }

 private:
  double speed_;  // [m/s]
};

}  // namespace slammot
