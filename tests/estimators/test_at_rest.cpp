// A camera that stands still. Nothing tells depths there, and a pixel tells all the same whether
// its point moves.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <tuple>

#include "datasets/simulation/random/random_stream.h"
#include "datasets/simulation/scene/known_landmarks.h"
#include "datasets/simulation/scene/statements.h"
#include "eval/configuration/registry.h"
#include "eval/configuration/setup.h"

namespace slammot {
namespace {

constexpr int kFrames = 40;
constexpr int kPoints = 80;
constexpr int kMoving = 6;
constexpr int kDecided = 10;  // frames

// Of points before the camera, the first few move across its line of sight, at any depth.
Sequence from_rest(std::uint64_t seed) {
  RandomStream random(seed, "points");
  std::vector<ScenePoint> points;
  for (int i = 0; i < kPoints; ++i) {
    const double depth = random.uniform(3.0, 11.0);
    const Eigen::Vector3d at(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 1.0);
    ScenePoint point{i, depth * at};
    if (i < kMoving) point.velocity = {at.x() < 0.0 ? 0.9 : -0.9, 0.0, 0.1};
    points.push_back(point);
  }
  RecordingOptions options;
  options.frames = kFrames;
  Sequence sequence = record(options, std::vector<CameraState>(kFrames), points, seed);
  sequence.known = choose_known({}, sequence, seed);
  state({}, prior_of(sequence), seed, sequence);
  return sequence;
}

class AtRest : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

TEST_P(AtRest, TellsWhatMovesFromWhatRests) {
  const auto& [family, model] = GetParam();
  int taken = 0, moving = 0, resting = 0, blamed = 0;
  long undone = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Sequence sequence = from_rest(seed);
    Configuration configuration;
    assign(configuration, {"landmark", model});
    const EstimatorRow& row = find_estimator(family);
    row.adjust(configuration);
    const auto estimator = row.make(make_setup(sequence, configuration), configuration);
    NoStages stages;
    for (const Frame& frame : sequence.frames) {
      estimator->process(frame, stages);
      if (frame.index < kDecided) continue;
      for (const LandmarkEstimate& landmark : estimator->landmarks_measured(frame.index)) {
        const bool moves = landmark.track < kMoving;
        (moves ? taken : resting) += landmark.label == Label::kStatic ? 1 : 0;
        (moves ? moving : blamed) += landmark.label == Label::kMoving ? 1 : 0;
      }
    }
    for (const Mechanism& device : estimator->in_force()) {
      if (device.name == "labels undone") undone += device.acted;
    }
  }
  std::printf("moving: %d said to move, %d to rest; at rest: %d to rest, %d to move; %ld undone\n",
              moving, taken, resting, blamed, undone);
  EXPECT_GT(moving, 400);
  EXPECT_LE(50 * taken, moving);
  EXPECT_LE(50 * blamed, resting);
  EXPECT_LT(undone, 20);
}

INSTANTIATE_TEST_SUITE_P(
    Families, AtRest,
    testing::Combine(testing::Values("ekf", "window"),
                     testing::Values("dynamic_inverse_depth", "scaled_velocity")),
    [](const auto& tested) { return std::get<0>(tested.param) + "_" + std::get<1>(tested.param); });

}  // namespace
}  // namespace slammot
