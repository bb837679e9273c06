// The cameras in a sliding window, and what was believed of those that left.
#pragma once

#include <vector>

#include "models/measurement.h"
#include "smoothers/graph/graph.h"

namespace slammot {

struct WindowFrame {
  int number = 0;  // counted from the first frame processed
  int index = 0;   // Frame::index
  double timestamp = 0.0;
  GraphCamera camera;  // its position lives on as the anchor of the landmarks initialised here
};

class CameraWindow {
 public:
  explicit CameraWindow(Graph& graph) : graph_(graph) {
    left_.reserve(1024);  // it grows in every frame, which is not to ask for memory
  }

  // The first camera with its prior; each later one at its prediction, thesis 2.1.1, with its
  // motion factor. Throws std::invalid_argument for a singular motion noise.
  void start(const Frame& frame, const InitialCamera& initial);
  void advance(const Frame& frame, double dt, const MotionNoise& noise);

  // Takes the oldest out of the window; its variables are the caller's to marginalise.
  void leave();

  const std::vector<WindowFrame>& frames() const { return frames_; }
  const WindowFrame& oldest() const { return frames_.front(); }
  const WindowFrame& newest() const { return frames_.back(); }
  // The frame whose position this is; frames().end() when it has left.
  std::vector<WindowFrame>::const_iterator find(VariableId position) const;

  CameraState state(const WindowFrame& frame) const { return graph_.camera(frame.camera); }

  struct Left {
    double timestamp;
    CameraState state;  // as it was believed when it left
  };
  const std::vector<Left>& left() const { return left_; }
  // Every camera so far, oldest first: as it left, or as it is in the window.
  std::vector<CameraState> all() const;

 private:
  void add(const Frame& frame, int number, const CameraState& x);

  Graph& graph_;
  std::vector<WindowFrame> frames_;
  std::vector<Left> left_;
};

}  // namespace slammot
