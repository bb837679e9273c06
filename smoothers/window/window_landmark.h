// Landmarks in a sliding window, and what happens to those that move: a chain grows with each
// frame, begins again where a label is undone, and ends when the landmark is pruned.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "models/label.h"
#include "smoothers/window/camera_window.h"

namespace slammot {

// Its place in the graph, and what the window remembers of it.
struct WindowLandmark {
  int track = 0;
  LandmarkId id = 0;
  int last_used = 0;  // Frame::index of its newest accepted measurement
  // Camera position of a frame. Free: where its chain begins; static: of its label; static and
  // pruned: the last that can hold one of its pixels.
  VariableId base = 0;
  bool is_free = false;      // it has not become static (its chain stays until the next update)
  bool is_entering = false;  // known beforehand, and not in the equations yet
  bool drops = false;        // it has become static: w is marginalised before the next update
};

struct WindowLandmarks {
  std::map<int, WindowLandmark> current;  // by track
  std::vector<WindowLandmark> pruned;     // with measurements in the window

  WindowLandmark& at(int track) { return current.at(track); }
  const WindowLandmark& at(int track) const { return current.at(track); }

  template <typename Function>
  void for_each(Function&& function) {
    for (auto& [track, landmark] : current) function(landmark);
    for (WindowLandmark& landmark : pruned) function(landmark);
  }
};

// One step more, thesis (2.5), with the acceleration noise of unknown and moving landmarks.
void extend_chain(Graph& graph, LandmarkId id, Label label, double dt);

// Steps after the last measurement say nothing; they are removed.
void end_chain(GraphLandmark& landmark);

// Where the pixels in the window of one that is released begin, but not before the time of its y:
// it was at rest then.
const WindowFrame& base_of_release(const GraphLandmark& landmark, const CameraWindow& cameras);

// Its chain begins in this frame, to which y and w belong, and its pixels are measured along it.
// They keep their linearisation: a landmark at rest is the same point in all of them.
void begin_chain(Graph& graph, LandmarkId id, const WindowFrame& base, const CameraWindow& cameras);

}  // namespace slammot
