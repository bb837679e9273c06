#include "datasets/simulation/circle.h"

#include <cmath>
#include <numbers>

#include "datasets/simulation/path.h"

namespace slammot {

Parameters parameters(CircleOptions& o) {
  return joined({{"radius", "of the circle [m]", &o.radius, kAbove0},
                 {"loop_frames", "frames of one loop", &o.loop_frames, 1},
                 {"speed_variation", "amplitude over mean of the speed", &o.speed_variation, 0},
                 {"speed_cycles", "variations of the speed in a loop", &o.speed_cycles, 1},
                 {"bobbing", "amplitude of the vertical motion [m]", &o.bobbing, 0},
                 {"view", "viewing direction right of the tangent [deg]", &o.view_deg, -180}},
                parameters(o.scene));
}

namespace {

CameraState circle_camera(const CircleOptions& options, double time) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  constexpr double kBobs = 3.0;  // a loop
  const double loop_time = options.loop_frames / options.scene.recording.rate;
  const double s = time / loop_time;
  const double cycles = options.speed_cycles;
  const double variation = options.speed_variation;
  const double angle = kTurn * s - variation / cycles * std::sin(kTurn * cycles * s);
  const double rate = kTurn / loop_time * (1.0 - variation * std::cos(kTurn * cycles * s));
  const double up = options.bobbing * std::sin(kTurn * kBobs * s);
  const double r = options.radius;
  const Eigen::Vector3d position(r * (1.0 - std::cos(angle)), -up, r * std::sin(angle));
  CameraState camera = camera_on_path({position, angle, r * rate, rate},
                                      options.view_deg * std::numbers::pi / 180.0);
  const double up_rate = kTurn * kBobs / loop_time;
  camera.velocity.y() = -options.bobbing * up_rate * std::cos(kTurn * kBobs * s);
  return camera;
}

}  // namespace

Sequence simulate_circle(const CircleOptions& options, std::uint64_t seed) {
  const RecordingOptions& recording = options.scene.recording;
  std::vector<CameraState> trajectory;
  for (int i = 0; i < recording.frames; ++i) {
    trajectory.push_back(circle_camera(options, recording.time(i)));
  }
  return simulate_in_volume(options.scene, {options.radius, 0.0, 0.0}, trajectory, seed);
}

}  // namespace slammot
