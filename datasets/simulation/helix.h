// Scenarios `helix` and `helix_unobservable` (thesis 3.1.1 and 3.1.4): 39 known static points
// (tracks 101 to 139), and three targets: 1 static, 2 moving with (1, 0, 0) m/s, 3 with (0, 0, 0.5)
// m/s.
//
// The camera looks along +z. helix: r = (R cos wt, R sin wt, v t), always accelerating.
// helix_unobservable: r = (0, 0, v t). There target 3, whose start is a multiple lambda of target
// 1's and whose velocity is (1 - lambda) that of the camera, has the projections of target 1 for
// ever; with the default v = 1 m/s, lambda = 1/2. Targets are seen from frame 1 on, since what is
// seen in frame 0 enters as static by rule. The thesis gives no radius, rate or places: these are
// ours.
#pragma once

#include "datasets/simulation/scene/recording.h"
#include "datasets/simulation/scene/statements.h"

namespace slammot {

struct HelixOptions {
  HelixOptions() {
    recording.frames = 150;
    recording.max_depth = 25.0;
  }
  RecordingOptions recording;
  StatementOptions statements;
  double radius = 1.0;   // R [m]
  double turns = 2.0;    // in ten seconds
  double forward = 1.0;  // v [m/s]
  int known = 39;
  double known_sigma = 1e-3;  // [m]
};
Parameters parameters(HelixOptions& options);

Sequence simulate_helix(const HelixOptions& options, std::uint64_t seed);
Sequence simulate_helix_unobservable(const HelixOptions& options, std::uint64_t seed);

}  // namespace slammot
