#include "datasets/simulation/scene/disturbances.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "datasets/simulation/random/random_stream.h"

namespace slammot {

Parameters parameters(DisturbanceOptions& o) {
  return {{"outliers", "share of the measurements that are random pixels", &o.outliers, 0},
          {"gap", "jump of the clock half way, while nothing moves [s]", &o.gap, 0},
          {"empty", "frames without measurements about the middle [s]", &o.empty, 0},
          {"teleport", "displacement of the camera to its right half way [m]", &o.teleport, 0}};
}

std::vector<CameraState> displaced(const DisturbanceOptions& options,
                                   std::vector<CameraState> trajectory) {
  if (options.teleport == 0.0) return trajectory;  // to the bit
  const size_t half = trajectory.size() / 2;
  const Eigen::Vector3d by =
      trajectory[half].orientation * Eigen::Vector3d(options.teleport, 0.0, 0.0);
  for (size_t i = half; i < trajectory.size(); ++i) trajectory[i].position += by;
  return trajectory;
}

namespace {

void replace_outliers(double share, std::uint64_t seed, Sequence& sequence) {
  RandomStream random(seed, "outliers");
  for (Frame& frame : sequence.frames) {
    for (Observation& z : frame.observations) {
      const double drawn = random.uniform(0.0, 1.0);
      const double u = random.uniform(0.0, sequence.camera.width - 1.0);
      const double v = random.uniform(0.0, sequence.camera.height - 1.0);
      if (drawn < share) z.pixel = {u, v};
    }
  }
}

}  // namespace

void disturb(const DisturbanceOptions& options, std::uint64_t seed, Sequence& sequence) {
  if (options.outliers > 1.0) {
    throw std::invalid_argument(
        fmt::format("outliers: must be at most 1, not {}", options.outliers));
  }
  replace_outliers(options.outliers, seed, sequence);
  if (sequence.frames.size() < 2) return;
  const double start = sequence.frames.front().timestamp;
  const double middle = start + (sequence.frames.back().timestamp - start) / 2.0;
  for (Frame& frame : sequence.frames) {
    if (2.0 * std::abs(frame.timestamp - middle) <= options.empty && options.empty > 0.0) {
      frame.observations.clear();
      frame.other_views.clear();
    }
  }
  for (size_t i = sequence.frames.size() / 2; i < sequence.frames.size(); ++i) {
    sequence.frames[i].timestamp += options.gap;
  }
}

}  // namespace slammot
