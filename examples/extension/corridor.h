// A scenario: its options, their parameters, and a function of options and seed.
#pragma once

#include <slammot/datasets/simulation/random/random_stream.h>
#include <slammot/datasets/simulation/scenario.h>
#include <slammot/datasets/simulation/scene/recording.h>
#include <slammot/datasets/simulation/scene/statements.h>

namespace slammot {

// A camera at constant speed along z, between two walls of static points.
struct CorridorOptions {
  CorridorOptions() { recording.frames = 100; }
  RecordingOptions recording;
  StatementOptions statements;
  double speed = 1.0;  // [m/s]
  double width = 4.0;  // between the walls [m]
  int points = 200;
};

inline Parameters parameters(CorridorOptions& o) {
  return joined({{"speed", "of the camera [m/s]", &o.speed, kAbove0},
                 {"width", "between the walls [m]", &o.width, kAbove0},
                 {"points", "on both walls together", &o.points, 1}},
                joined(parameters(o.recording), parameters(o.statements)));
}

inline Sequence simulate_corridor(const CorridorOptions& options, std::uint64_t seed) {
  const RecordingOptions& recording = options.recording;
  std::vector<CameraState> trajectory;
  for (int i = 0; i < recording.frames; ++i) {
    CameraState& camera = trajectory.emplace_back();
    camera.velocity = {0.0, 0.0, options.speed};
    camera.position = camera.velocity * recording.time(i);
  }
  const double length = trajectory.back().position.z() + recording.max_depth;
  RandomStream random(seed, "points");
  std::vector<ScenePoint> points;
  for (int i = 0; i < options.points; ++i) {
    const double x = (i % 2 == 0 ? 0.5 : -0.5) * options.width;
    const double y = random.uniform(-1.0, 1.0), z = random.uniform(0.0, length);
    points.push_back({i, {x, y, z}});
  }
  Sequence sequence = record(recording, trajectory, points, seed);
  state(options.statements, prior_of(sequence), seed, sequence);
  return sequence;
}

}  // namespace slammot
