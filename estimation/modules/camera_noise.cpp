#include "estimation/modules/camera_noise.h"

#include <algorithm>
#include <cmath>

namespace slammot {

namespace {

constexpr double kForgetting = 0.1;  // a: about ten frames
constexpr double kSharedNis = 2.0;   // mean of a chi-square(2)
constexpr double kJolt = 13.8;       // its 99.9% quantile

}  // namespace

double AdaptiveCameraNoise::Drift::add(const Eigen::Vector3d& change, const CameraEstimate& before,
                                       const CameraEstimate& after, int at, double sigma) {
  const double shrunk = before.covariance.diagonal().segment<3>(at).sum() -
                        after.covariance.diagonal().segment<3>(at).sum();
  mean += kForgetting * (change - mean);
  variance = (1.0 - kForgetting) * (1.0 - kForgetting) * variance +
             kForgetting * kForgetting * (3.0 * sigma * sigma + std::max(0.0, shrunk));
  return variance > 0.0 ? std::max(1.0, mean.squaredNorm() / variance) : 1.0;
}

double AdaptiveCameraNoise::jolt(double median_nis) {
  return median_nis > kJolt ? median_nis / kSharedNis : 1.0;
}

void AdaptiveCameraNoise::note(double median_nis) {
  asked_ += kForgetting * (factor_ * std::min(median_nis, kJolt) / kSharedNis - asked_);
}

void AdaptiveCameraNoise::learn(const CameraEstimate& before, const CameraEstimate& after,
                                double dt) {
  const double linear = linear_.add(after.state.velocity - before.state.velocity, before, after,
                                    kVelocity, stated_.acceleration * dt);
  const double angular =
      angular_.add(after.state.angular_velocity - before.state.angular_velocity, before, after,
                   kAngularVelocity, stated_.angular_acceleration * dt);
  factor_ = std::max(1.0, asked_);
  of_next_.acceleration = std::sqrt(std::max(linear, factor_)) * stated_.acceleration;
  of_next_.angular_acceleration =
      std::sqrt(std::max(angular, factor_)) * stated_.angular_acceleration;
  widened_ += std::max({linear, angular, factor_}) > 1.0 ? 1 : 0;
}

}  // namespace slammot
