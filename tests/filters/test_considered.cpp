// Landmarks labelled moving correct nothing but themselves where enough static ones are measured.
// Who is considered: estimation/test_consider.cpp. What it does to a run: eval/studies/believable.
#include <gtest/gtest.h>

#include <algorithm>

#include "datasets/simulation/scenario.h"
#include "estimation/modules/consider.h"
#include "eval/configuration/setup.h"
#include "filters/ekf.h"

namespace slammot {
namespace {

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
Moved moved(Movers movers, const EkfOptions& options = {}, Gauge gauge = Gauge::kScale) {
  const Sequence sequence = simulate("circle", {}, 5);
  Configuration configuration;
  configuration.ekf = options;
  const slammot::Setup setup = make_setup(sequence, configuration);
  ModelOptions models;
  models.classifier.name = "truth";
  models.gate = {1.0, 1.0};
  models.policy.movers = movers;
  models.gauge = gauge;
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

TEST(Considered, AMoverMovesItselfAndNotTheCamera) {
  const Moved alone = moved(Movers::kConsidered), with_others = moved(Movers::kJoint);
  EXPECT_GT(alone.static_measured, kStaticEnough);
  EXPECT_LT(alone.camera.norm(), kSame);
  EXPECT_GT(alone.landmarks, 1e-3);
  EXPECT_GT(with_others.camera.norm(), kDiffers);
}

TEST(Considered, WhateverIsKeptButNotWhereJacobiansNeedNoCare) {
  const auto camera = [](const EkfOptions& options, Gauge gauge = Gauge::kScale) {
    return moved(Movers::kConsidered, options, gauge).camera.norm();
  };
  EXPECT_LT(camera({.linearisation = FilterLinearisation::kFej}), kSame);
  EXPECT_LT(camera({}, Gauge::kNone), kSame);
  EXPECT_LT(camera({}, Gauge::kHeading), kSame);
  EXPECT_GT(camera({.linearisation = FilterLinearisation::kIdeal}), kDiffers);
}

}  // namespace
}  // namespace slammot
