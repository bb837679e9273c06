// How well a run claims to know the scale, beside what was stated of it.
//
// Images do not tell the scale. Where no landmark is known beforehand and the mean of the depths is
// in doubt, three statements do: the first speed |v| +- sigma_v, the mean inverse depth
// rho0 +- sigma, and sigma_a of the camera's accelerations, by the velocity's changes dv. Their
// information on the scale relative to itself is
//
//   I = (|v| / sigma_v)^2 + (rho0 / sigma)^2 + sum of min(3, (|dv| / (sigma_a dt))^2).
//
// Noise of that sigma has 3 in a frame on average; larger changes are those of an estimate that is
// lost. What movers' speeds and a fixed spread of depths tell is left out.
//
// A scale that is wrong by a share s moves the camera by s d, d being its way since the first pose.
// So a covariance P of the position implies a relative sigma of the scale of sqrt(d'Pd) / |d|^2 at
// most. A window states the information itself (FrameReport::scale_information). Estimators become
// too sure of the scale where their Jacobians were taken at different scales (docs/results.md).
#pragma once

#include <optional>

#include "estimation/estimator.h"
#include "eval/result/run_result.h"

namespace slammot {

struct StatedScale {
  double information = 0.0;   // of the first velocity and the mean depth
  double acceleration = 0.0;  // sigma_a [m/s^2]
};

// None where a landmark is known, or the mean of the depths, or where velocity and depth tell the
// scale to no better than half: first order does not hold there.
std::optional<StatedScale> stated_scale(const Setup& setup);

// The first frame whose covariance implies less than a third of the sigma that I does, I being that
// of the frames so far, or whose estimator states less than half of it. Nothing of cameras without
// covariance.
std::optional<RunWarning> scale_warning(const RunResult& run, const StatedScale& stated);

}  // namespace slammot
