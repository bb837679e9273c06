// Where the scale is not known it may move long after frames have left. What is kept of them must
// then say what their measurements say: the window's belief is compared with one that takes all
// measurements up again from the first frame.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"
#include "smoothers/window/window.h"
#include "tests/estimators/fixture/linearisation_fixture.h"

namespace slammot {
namespace {

constexpr int kFrames = 24;
constexpr int kTold = 18;        // the first frame in which depths are measured
constexpr int kAll = 1000;       // frames: none leaves the window
constexpr double kLarger = 1.3;  // the world that the depths tell

// Nothing known but a first velocity, to 11%; towards the end depths in metres, where they are
// told, of a world larger than that velocity's. Nothing moves, and pixels are exact, so
// that little but the scale is far from linear.
Sequence told(bool is_told) {
  Sequence sequence = simulate("circle",
                               {{"frames", std::to_string(kFrames)},
                                {"known", "0"},
                                {"moving", "0"},
                                {"noise", "0.1"},
                                {"depth_sigma", "0.02"}},
                               5);
  for (Frame& frame : sequence.frames) {
    for (Observation& z : frame.observations) {
      const double told = is_told && frame.index >= kTold ? kLarger : 0.0;
      z.depth *= told;
      z.depth_sigma *= told;
    }
  }
  return sequence;
}

CameraEstimate last_camera(const Sequence& sequence, Gauge gauge, int frames) {
  // At the beginning nothing measures the scale.
  const slammot::Setup setup = make_setup(told(false), Configuration{});
  ModelOptions models;
  models.landmark = "inverse_depth";
  models.gauge = gauge;
  WindowOptions options;
  options.frames = frames;
  options.iterations = 40;
  options.linearisation_error = 1e-8;
  const auto window = make_window(setup, models, options);
  NoStages stages;
  for (const Frame& frame : sequence.frames) window->process(frame, stages);
  return window->camera();
}

double largest_difference(const CameraEstimate& a, const CameraEstimate& b) {
  const Vector12d sigma = b.covariance.diagonal().cwiseSqrt();
  return boxminus(a.state, b.state).cwiseQuotient(sigma).cwiseAbs().maxCoeff();
}

TEST(ScaleMoved, WhatHasLeftTheWindowSaysWhatItsMeasurementsSay) {
  const Sequence sequence = told(true);
  const CameraEstimate all = last_camera(sequence, Gauge::kScale, kAll);
  const CameraEstimate before = last_camera(told(false), Gauge::kScale, kAll);
  const double moved = std::log(all.state.position.norm() / before.state.position.norm());
  EXPECT_GT(std::abs(moved), 0.2);

  for (const int frames : {5, 10}) {
    const CameraEstimate window = last_camera(sequence, Gauge::kScale, frames);
    const double state = largest_difference(window, all);
    const double covariance = test::relative_difference(window.covariance, all.covariance);
    std::printf("scale moved by %.3f, window of %d: state %.3f sigma, covariance %.4f\n", moved,
                frames, state, covariance);
    EXPECT_LT(state, 0.15);
    EXPECT_LT(covariance, 0.04);
  }
}

TEST(ScaleMoved, InPlainCoordinatesItIsFartherOff) {
  const Sequence sequence = told(true);
  const CameraEstimate all = last_camera(sequence, Gauge::kScale, kAll);
  const double plain = largest_difference(last_camera(sequence, Gauge::kNone, 5), all);
  const double chart = largest_difference(last_camera(sequence, Gauge::kScale, 5), all);
  std::printf("window of 5: state %.3f sigma, in plain coordinates %.3f\n", chart, plain);
  EXPECT_GT(plain, 3.0 * chart);
}

}  // namespace
}  // namespace slammot
