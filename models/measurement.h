// What an estimator is given for each frame, and what it is told about the sequence beforehand.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <vector>

#include "models/camera_state.h"

namespace slammot {

// A tracked point in one image. Pixels, the centre of the top-left pixel is (0, 0).
struct Observation {
  int track = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double relative_sigma = 1.0;  // of each coordinate, in units of the sequence's pixel_sigma
  int camera = 0;               // of the rig (models/rig.h)
  // Along the optical axis [m], measured by something else than images; sigma 0: not measured. Used
  // where the landmark is initialised.
  double depth = 0.0, depth_sigma = 0.0;

  bool has_depth() const { return depth_sigma > 0.0; }

  // Of each coordinate [px^2].
  double variance(double pixel_sigma) const {
    return relative_sigma * relative_sigma * pixel_sigma * pixel_sigma;
  }
};

inline bool is_same_view(const Observation& a, const Observation& b) {
  return a.track == b.track && a.camera == b.camera;
}

// Each once, of observations by track.
inline void tracks_of(std::span<const Observation> z, std::vector<int>& tracks) {
  tracks.clear();
  for (const Observation& one : z) {
    if (tracks.empty() || tracks.back() != one.track) tracks.push_back(one.track);
  }
}

struct Frame {
  int index = 0;           // its number in the sequence, also where frames were left out
  double timestamp = 0.0;  // [s], strictly increasing
  std::vector<Observation> observations;  // each track at most once, in increasing order
  // Of the other cameras of a rig: each track at most once a camera, by track and camera. A track
  // that camera 0 does not measure makes no landmark.
  std::vector<Observation> other_views;
};

// A landmark known beforehand; it fixes the scale. Position in W [m], one sigma for each axis [m].
struct KnownLandmark {
  int track = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double sigma = 0.0;
};

// The camera before the first frame, with the standard deviation of each of its four parts.
struct InitialCamera {
  CameraState state;
  double position_sigma = 1e-6;         // [m]
  double rotation_sigma = 1e-6;         // [rad]
  double velocity_sigma = 1.0;          // [m/s]
  double angular_velocity_sigma = 1.0;  // [rad/s]

  // Of each component of the error state.
  Vector12d sigmas() const {
    const Eigen::Vector3d one = Eigen::Vector3d::Ones();
    return (Vector12d() << position_sigma * one, rotation_sigma * one, velocity_sigma * one,
            angular_velocity_sigma * one)
        .finished();
  }
};

// What is known of the scene before it is seen; see DESIGN section 7 on what a wrong value does.
struct LandmarkPrior {
  double inverse_depth = 0.3;         // rho0 [1/m]
  double inverse_depth_sigma = 0.15;  // sigma_rho [1/m]
  double mean_sigma = 0.0;            // of rho0 itself, the same error for all [1/m]; 0: known
  double max_speed = 2.0;             // |v|max [m/s]; sigma_v = |v|max / 2, thesis (2.6)
  double acceleration = 1.0;          // sigma of unknown and moving landmarks' noise [m/s^2]
  double jerk = 1.0;                  // the same of models with an acceleration [m/s^3]
  double steady_time = 10.0;          // bounds that of unknown ones [s], see noise(); 0: no bound
  bool spread_follows_mean = false;   // sigma_rho in proportion to a mean that is estimated

  double velocity_sigma() const { return max_speed / 2.0; }

  // With the noise of one that is known to move, or may. What may be at rest is thought to keep its
  // velocity: in `steady_time` it changes by no more than velocity_sigma. Else a statement that
  // suits the movers hides that the others rest.
  LandmarkPrior noise(bool is_moving) const {
    LandmarkPrior result = *this;
    if (is_moving || steady_time <= 0.0) return result;
    result.acceleration = std::min(acceleration, velocity_sigma() / steady_time);
    result.jerk = std::min(jerk, acceleration / steady_time);
    return result;
  }
};

}  // namespace slammot
