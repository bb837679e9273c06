// A scenario, as docs/extending.md adds one: what stands between the `example` and `end` lines is
// named there, and that it compiles is half the test.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "datasets/simulation/scene/parameters.h"
#include "datasets/simulation/scene/random_stream.h"
#include "datasets/simulation/scene/recording.h"
#include "datasets/simulation/scene/statements.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

// [example: scenario]
// A camera at constant speed along z, between two walls of static points.
struct CorridorOptions {
  CorridorOptions() { recording.frames = 100; }
  RecordingOptions recording;
  StatementOptions statements;
  double speed = 1.0;  // [m/s]
  double width = 4.0;  // between the walls [m]
  int points = 200;
};

Parameters parameters(CorridorOptions& o) {
  return joined({{"speed", "of the camera [m/s]", &o.speed, kAbove0},
                 {"width", "between the walls [m]", &o.width, kAbove0},
                 {"points", "on both walls together", &o.points, 1}},
                joined(parameters(o.recording), parameters(o.statements)));
}

Sequence simulate_corridor(const CorridorOptions& options, std::uint64_t seed) {
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
// [end]

TEST(ExtendingScenario, IsSimulatedWithOverridesAndRun) {
  CorridorOptions options;
  apply({{"corridor.frames", "20"}, {"width", "3"}}, "corridor", parameters(options));
  EXPECT_THROW(apply({{"widht", "3"}}, "corridor", parameters(options)), std::invalid_argument);
  const Sequence sequence = simulate_corridor(options, 5), again = simulate_corridor(options, 5);
  ASSERT_EQ(sequence.frames.size(), 20u);
  ASSERT_FALSE(sequence.frames[0].observations.empty());
  EXPECT_EQ(sequence.frames[7].observations[0].pixel, again.frames[7].observations[0].pixel);
  const RunResult run = run_estimator(sequence, Configuration{}, "ekf");
  EXPECT_FALSE(run.diverged);
  EXPECT_EQ(run.filtered.size(), 20u);
}

}  // namespace
}  // namespace slammot
