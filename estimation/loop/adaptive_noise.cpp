#include "estimation/loop/adaptive_noise.h"

#include <algorithm>
#include <cmath>

namespace slammot {

namespace {

constexpr double kForgetting = 0.1;  // a: about ten frames

}  // namespace

double AdaptiveNoise::Drift::add(const Eigen::Vector3d& change, const CameraEstimate& before,
                                 const CameraEstimate& after, int at, double sigma) {
  const double shrunk = before.covariance.diagonal().segment<3>(at).sum() -
                        after.covariance.diagonal().segment<3>(at).sum();
  mean += kForgetting * (change - mean);
  variance = (1.0 - kForgetting) * (1.0 - kForgetting) * variance +
             kForgetting * kForgetting * (3.0 * sigma * sigma + std::max(0.0, shrunk));
  return variance > 0.0 ? std::max(1.0, mean.squaredNorm() / variance) : 1.0;
}

void AdaptiveNoise::learn(const CameraEstimate& before, const CameraEstimate& after, double dt) {
  const double linear = linear_.add(after.state.velocity - before.state.velocity, before, after,
                                    kVelocity, stated_.acceleration * dt);
  const double angular =
      angular_.add(after.state.angular_velocity - before.state.angular_velocity, before, after,
                   kAngularVelocity, stated_.angular_acceleration * dt);
  of_next_.acceleration = std::sqrt(linear) * stated_.acceleration;
  of_next_.angular_acceleration = std::sqrt(angular) * stated_.angular_acceleration;
}

}  // namespace slammot
