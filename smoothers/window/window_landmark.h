// A landmark in a sliding window: its place in the graph, and what the window remembers of it.
#pragma once

#include "smoothers/graph/graph.h"

namespace slammot {

struct WindowLandmark {
  int track = 0;
  LandmarkId id = 0;
  int last_used = 0;    // Frame::index of its newest accepted measurement
  VariableId base = 0;  // camera position of the frame where its chain begins
  bool is_free = false;
  bool drops = false;  // it has become static: w is marginalised before the next update
};

}  // namespace slammot
