// The true motion of camera and landmarks, where it is known: what results are judged by. The one
// estimator that may look at it has linearisation `ideal`, which takes its Jacobians there and so
// shows what an estimator loses by not knowing where to linearise.
#pragma once

#include <map>

#include "models/camera_state.h"
#include "models/label.h"

namespace slammot {

struct TruePoint {
  Eigen::Vector3d position;  // W [m]
  Eigen::Vector3d velocity;  // W [m/s]
};

struct TrueLandmark {
  Label label = Label::kStatic;       // its class: static or, if it ever moves, moving
  std::map<int, TruePoint> by_frame;  // by Frame::index; static: one entry, at any frame; moving:
                                      // an entry for each frame that has a row

  // Where it is at a frame: for a static one always the same; nothing for a moving one without a
  // row.
  const TruePoint* at(int frame) const;

  // Static while it stands, at a velocity of exactly zero; its class where its velocity is not
  // known.
  Label label_at(int frame) const;
};

struct Truth {
  std::map<int, CameraState> cameras;     // by Frame::index
  std::map<int, TrueLandmark> landmarks;  // by track
};

}  // namespace slammot
