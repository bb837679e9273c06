#include "datasets/simulation/helix.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "datasets/simulation/random/random_stream.h"

namespace slammot {

Parameters parameters(HelixOptions& o) {
  return joined({{"radius", "of the helix [m]", &o.radius, 0},
                 {"turns", "of the helix in ten seconds", &o.turns, 0},
                 {"forward", "speed along the axis [m/s]", &o.forward, -100},
                 {"known", "number of known points", &o.known, 0},
                 {"known_sigma", "of each axis [m]", &o.known_sigma, kAbove0}},
                joined(parameters(o.recording), parameters(o.statements)));
}

namespace {

CameraState helix_camera(const HelixOptions& options, double radius, double time) {
  const double rate = 2.0 * std::numbers::pi * options.turns / 10.0;
  const double c = std::cos(rate * time), s = std::sin(rate * time);
  CameraState camera;
  camera.position = Eigen::Vector3d(radius * c, radius * s, options.forward * time);
  camera.velocity = Eigen::Vector3d(-radius * rate * s, radius * rate * c, options.forward);
  return camera;
}

std::vector<ScenePoint> targets() {
  const Eigen::Vector3d start(1.0, 0.6, 16.0);  // of target 1
  return {{1, start, Eigen::Vector3d::Zero(), 1},
          {2, {-5.5, -0.5, 18.0}, {1.0, 0.0, 0.0}, 1},
          {3, 0.5 * start, {0.0, 0.0, 0.5}, 1}};
}

// Each in view of some frame, every fourth of frame 0, at a depth of 4 to 20 m.
std::vector<ScenePoint> known_points(const HelixOptions& options,
                                     const std::vector<CameraState>& trajectory,
                                     std::uint64_t seed) {
  const Camera camera = simulated_camera(options.recording);
  RandomStream random(seed, "known points");
  std::vector<ScenePoint> points;
  for (int i = 0; i < options.known; ++i) {
    const int frame = i % 4 == 0 ? 0 : random.below(options.recording.frames);
    const double u = random.uniform(0.0, camera.width - 1);
    const double v = random.uniform(0.0, camera.height - 1);
    const double depth = random.uniform(4.0, 20.0);
    const CameraState& from = trajectory[static_cast<size_t>(frame)];
    const Eigen::Vector3d ray = camera.unproject({u, v})->ray;
    points.push_back({101 + i, from.position + from.orientation * (depth * ray)});
  }
  return points;
}

Sequence simulate_from(const HelixOptions& options, double radius, std::uint64_t seed) {
  std::vector<CameraState> trajectory;
  for (int i = 0; i < options.recording.frames; ++i) {
    trajectory.push_back(helix_camera(options, radius, options.recording.time(i)));
  }
  const std::vector<ScenePoint> known = known_points(options, trajectory, seed);
  std::vector<ScenePoint> points = targets();
  points.insert(points.end(), known.begin(), known.end());
  Sequence sequence = record(options.recording, trajectory, points, seed);
  RandomStream random(seed, "known");
  for (const ScenePoint& point : known) {
    const Eigen::Vector3d error = options.known_sigma * random.normals<3>();
    sequence.known.push_back({point.track, point.position + error, options.known_sigma});
  }
  state(options.statements, prior_of(sequence), seed, sequence);
  return sequence;
}

}  // namespace

Sequence simulate_helix(const HelixOptions& options, std::uint64_t seed) {
  return simulate_from(options, options.radius, seed);
}

Sequence simulate_helix_unobservable(const HelixOptions& options, std::uint64_t seed) {
  return simulate_from(options, 0.0, seed);
}

}  // namespace slammot
