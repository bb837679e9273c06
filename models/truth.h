// The true motion of camera and landmarks, for the one estimator that may look at it: linearisation
// `ideal`, which takes its Jacobians there and so shows what an estimator loses by not knowing
// where to linearise.
#pragma once

#include <map>

#include "slammot/models/camera_state.h"

namespace slammot {

struct TrueMotion {
  Eigen::Vector3d position;  // W [m]
  Eigen::Vector3d velocity;  // W [m/s]
};

struct Truth {
  std::map<int, CameraState> cameras;                  // by Frame::index
  std::map<int, std::map<int, TrueMotion>> landmarks;  // by track and Frame::index
  std::map<int, TrueMotion> statics;                   // by track
};

}  // namespace slammot
