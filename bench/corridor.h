// The benchmarks' world: a camera that looks sideways while it passes a long strip of static and
// moving points. What leaves the view stays in the map, so that the map grows without end while a
// frame measures the same number of landmarks; births and deaths come in every frame.
#pragma once

#include "estimation/estimator.h"
#include "eval/configuration/configuration.h"

namespace slammot::bench {

struct Corridor {
  Setup setup;
  std::vector<Frame> frames;
  std::vector<CameraState> truth;  // as `frames`
};

struct CorridorOptions {
  int frames = 0;
  int visible = 40;               // landmarks measured in a frame: the cap of the map's policy
  double moving_fraction = 0.25;  // of the points
  double speed = 1.5;             // of the camera [m/s]: how long a landmark is in view
};

Corridor make_corridor(const CorridorOptions& options);

// The thesis's models, labels and filter, behind a gate, with as many landmarks as come, `visible`
// at a time: what is timed is the arithmetic of one joint update for all.
Configuration thesis_configuration(const CorridorOptions& options);

}  // namespace slammot::bench
