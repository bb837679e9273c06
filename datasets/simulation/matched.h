// Scenario `matched`: everything is drawn from the models that the estimators use, so that theory
// says what their NEES must be.
//
// The first camera is drawn around the stated one with the stated sigmas; then x' = f(x) [+] w,
// w ~ N(0, Q) with white noise, or an impulse before each step (camera_motion.h). A landmark is
// born at a pixel uniform in the image, with inverse distance ~ N(rho0, sigma_rho^2); a moving one
// with velocity ~ N(0, sigma_v^2 I), sigma_v = max_speed / 2, and Wiener noise of its own
// (landmark.h) from then on. Those of frame 0 are static, as the rule of the first frame has it.
// Pixel noise is Gaussian and selects nothing: a landmark is seen while its noise-free pixel lies
// in the image, and once it has left it never returns, because an estimator would start it anew
// from a prior that it no longer follows.
#pragma once

#include "datasets/simulation/scene/recording.h"

namespace slammot {

struct MatchedOptions {
  MatchedOptions() {
    recording.frames = 150;
    recording.max_depth = 1e6;  // a limit would select
    initial.state.velocity.z() = 1.0;
    initial.position_sigma = 1e-3;
    initial.rotation_sigma = 1e-3;
    initial.velocity_sigma = 0.1;
    initial.angular_velocity_sigma = 0.1;
  }
  RecordingOptions recording;
  InitialCamera initial;          // the mean
  StatedMotion motion{1.0, 0.3};  // [m/s^2], [rad/s^2]
  LandmarkPrior prior{0.2, 0.03, 0.0, 2.0, 0.1};
  double moving_fraction = 0.5;  // of those born after frame 0
  int visible = 30;              // landmarks in every frame
  int known = 6;                 // of them, in frame 0
  double known_sigma = 1e-3;     // [m]
  int impulse = 0;               // the camera's noise: 1 as impulses, 0 as white noise
};
Parameters parameters(MatchedOptions& options);

Sequence simulate_matched(const MatchedOptions& options, std::uint64_t seed);

}  // namespace slammot
