// Camera motion (thesis 2.1.1, after Montiel et al. 2006): constant velocity and angular velocity,
//
//   r' = r + v dt,   R' = R Exp(omega dt),   v' = v,   omega' = omega,   x' = f(x) [+] w, w ~ N(0,
//   Q).
//
// `sigma_a` [m/s^2] is the standard deviation of the acceleration taken over one step, so that both
// discretisations give the velocity the same variance (sigma_a dt)^2 per step:
//   impulse      v gets n dt at the start of the step, and r follows: rank 6 (the thesis, Montiel).
//   white_noise  the velocity is a Wiener process within the step, [dt^2/3 dt/2; dt/2 1] (sigma_a
//   dt)^2
//                for (r, v): full rank, which a factor graph needs, because it inverts Q.
// The same holds for the rotation with `sigma_alpha` [rad/s^2].
#pragma once

#include "models/camera_state.h"

namespace slammot {

enum class NoiseDiscretisation { kWhiteNoise, kImpulse };

struct MotionNoise {
  double acceleration = 2.0;          // sigma_a [m/s^2]
  double angular_acceleration = 3.0;  // sigma_alpha [rad/s^2]
  NoiseDiscretisation discretisation = NoiseDiscretisation::kWhiteNoise;
};

// With `factor` times the variance.
inline MotionNoise scaled(MotionNoise noise, double factor) {
  noise.acceleration *= std::sqrt(factor);
  noise.angular_acceleration *= std::sqrt(factor);
  return noise;
}

// f(x), thesis (2.2) and the constant-velocity model it names.
template <typename T>
CameraStateT<T> predict(const CameraStateT<T>& x, double dt) {
  CameraStateT<T> y = x;
  y.position += x.velocity * T(dt);
  y.orientation = x.orientation * exp_so3(Vector3<T>(x.angular_velocity * T(dt)));
  return y;
}

// F = d f(x) / dx in error states, 12x12.
Matrix12d predict_jacobian(const CameraState& x, double dt);

// Q of one step, 12x12, in the error state of the predicted camera.
Matrix12d camera_noise(const MotionNoise& noise, const CameraState& x, double dt);

// The 2x2 pattern of (position, velocity) noise per axis for a unit acceleration sigma, white
// noise.
Eigen::Matrix2d white_noise_pattern(double dt);

}  // namespace slammot
