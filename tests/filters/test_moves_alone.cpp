// Landmarks labelled moving correct nothing but themselves where enough static ones are measured.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"
#include "tests/filters/pose_nees.h"

namespace slammot {
namespace {

constexpr int kNever = 0, kDefault = EkfOptions{}.static_enough;

// The frame with the pixels of what moves half a pixel off.
Frame with_movers_shifted(const Sequence& sequence, const slammot::Setup& setup, int index) {
  Frame frame = sequence.frames[static_cast<std::size_t>(index)];
  for (Observation& z : frame.observations) {
    const auto label = setup.true_labels.find(z.track);
    if (label != setup.true_labels.end() && label->second == Label::kMoving) {
      z.pixel += Eigen::Vector2d(0.5, -0.5);
    }
  }
  return frame;
}

constexpr int kLast = 20;

struct Moved {
  Vector12d camera;
  double landmarks = 0.0;   // the largest difference of one that moves [m]
  int static_measured = 0;  // in the last frame
};

// By how much estimates differ when movers are measured elsewhere in the last frame.
Moved moved(int static_enough, FilterLinearisation linearisation = FilterLinearisation::kStandard) {
  const Sequence sequence = simulate("circle", {}, 5);
  Configuration configuration;
  configuration.ekf.linearisation = linearisation;
  const slammot::Setup setup = make_setup(sequence, configuration);
  ModelOptions models;
  models.classifier.name = "truth";
  models.gate = {1.0, 1.0};
  EkfOptions options;
  options.linearisation = linearisation;
  options.static_enough = static_enough;
  const auto here = make_ekf(setup, models, options), there = make_ekf(setup, models, options);
  NoStages stages;
  for (int k = 0; k < kLast; ++k) {
    here->process(sequence.frames[static_cast<std::size_t>(k)], stages);
    there->process(sequence.frames[static_cast<std::size_t>(k)], stages);
  }
  Moved result;
  result.static_measured = here->process(sequence.frames[kLast], stages).accepted_static;
  there->process(with_movers_shifted(sequence, setup, kLast), stages);
  result.camera = boxminus(here->camera().state, there->camera().state);
  const auto a = here->landmarks(), b = there->landmarks();
  EXPECT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (a[i].label != Label::kMoving) continue;
    result.landmarks = std::max(result.landmarks, (a[i].position - b[i].position).norm());
  }
  return result;
}

constexpr double kSame = 1e-12, kDiffers = 1e-5;

TEST(MovesAlone, AMoverMovesItselfAndNotTheCamera) {
  const Moved alone = moved(kDefault), with_others = moved(kNever);
  EXPECT_GT(alone.static_measured, kDefault);
  EXPECT_LT(alone.camera.norm(), kSame);
  EXPECT_GT(alone.landmarks, 1e-3);
  EXPECT_GT(with_others.camera.norm(), kDiffers);
}

TEST(MovesAlone, AsSoonAsSoManyAreStatic) {
  const int measured = moved(kDefault).static_measured;
  EXPECT_LT(moved(measured).camera.norm(), kSame);
  EXPECT_GT(moved(measured + 1).camera.norm(), kDiffers);
}

TEST(MovesAlone, NotWhereJacobiansNeedNoCareOrEveryUpdateChangesCoordinates) {
  EXPECT_LT(moved(kDefault, FilterLinearisation::kFej).camera.norm(), kSame);
  EXPECT_GT(moved(kDefault, FilterLinearisation::kIdeal).camera.norm(), kDiffers);
  EXPECT_GT(moved(kDefault, FilterLinearisation::kInvariant).camera.norm(), kDiffers);
}

// The mean NEES of the pose with true labels, the movers' alone or with the others.
double mean_nees(std::uint64_t seed, int static_enough) {
  const Sequence sequence =
      simulate("circle", {{"frames", "200"}, {"moving", "600"}, {"first_moving", "14"}}, seed);
  Configuration configuration;
  configuration.model.classifier.name = "truth";
  configuration.ekf.static_enough = static_enough;
  const slammot::Setup setup = make_setup(sequence, configuration);
  const auto ekf = make_ekf(setup, configuration.model, configuration.ekf);
  return mean_pose_nees(*ekf, sequence);
}

// The seeds are the first there are. On 50 others: docs/consistency.md, "Movers and the camera".
TEST(MovesAlone, MakesTheCameraMoreConsistent) {
  constexpr int kSeeds = 6;
  double ratio = 1.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const double alone = mean_nees(seed, kDefault), with_others = mean_nees(seed, kNever);
    std::printf("seed %d: NEES %.1f, with the others %.1f\n", static_cast<int>(seed), alone,
                with_others);
    ratio *= std::pow(alone / with_others, 1.0 / kSeeds);
  }
  std::printf("geometric mean of the ratio: %.2f\n", ratio);
  EXPECT_LT(ratio, 0.9);
}

}  // namespace
}  // namespace slammot
