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
  bool is_entering = false;        // known beforehand, and not in the equations yet
  std::optional<int> rests_since;  // WindowFrame::number, when a classifier found it static
  double rest_time = 0.0;          // of the frame that y is of, should its motion be held
  bool drops = false;              // it has become static: w is marginalised before the next update
};

// A measurement in the window that its landmark does not use, for `window.retest`.
struct RefusedPixel {
  Observation z;
  VariableId position = 0;  // of the frame's camera
};

struct RetestedPixel {
  LandmarkId landmark = 0;
  RefusedPixel at;
  bool is_held = true;  // else refused so far
  double nis = 0.0;     // given all others
};

struct RetestCounts {
  int let_go = 0, admitted = 0;
  bool operator==(const RetestCounts&) const = default;
};

}  // namespace slammot
