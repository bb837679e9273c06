// A landmark in a sliding window. Its chain (landmark_chain.h) goes from the base, the oldest frame
// of the window that concerns it, to the newest frame.
#pragma once

#include "smoothers/graph/landmark_variables.h"

namespace slammot {

// A measurement of a free landmark in the window, with its factor.
struct WindowPixel : MeasuredPixel {
  FactorId factor = 0;
};

struct WindowLandmark : LandmarkVariables {
  int track = 0;
  int last_used = 0;  // Frame::index of its newest accepted measurement
  FactorId w_prior = 0;
  VariableId base = 0;                 // camera position of the base's frame
  std::vector<FactorId> noise_priors;  // as `noises`
  std::vector<WindowPixel> pixels;     // while it is free
};

}  // namespace slammot
