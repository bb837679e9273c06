// A simulated camera that looks at a scene of points: visibility, pixels with noise, and the truth.
//
// A point is seen when its noise-free projection lies inside the image at a depth (z) within
// limits; the noisy pixel is recorded, even if it lies outside.
#pragma once

#include "datasets/sequence/sequence.h"
#include "datasets/simulation/parameters/parameters.h"
#include "datasets/simulation/scene/manoeuvre.h"
#include "datasets/simulation/scene/schedule.h"

namespace slammot {

struct RecordingOptions {
  int frames = 600;
  double rate = 15.0;  // [Hz]
  int width = 640, height = 480;
  double field_of_view_deg = 79.48;    // horizontal
  double noise = 1.0;                  // simulated [px]
  std::optional<double> stated_noise;  // as `noise` when not set
  double min_depth = 0.5, max_depth = 12.0;
  double stereo = 0.0;       // baseline of a second camera [m]; 0: none
  double depth_sigma = 0.0;  // of a depth at a point's first pixel [m]; 0: none

  double dt() const { return 1.0 / rate; }
  double time(int frame) const { return frame / rate; }
};
Parameters parameters(RecordingOptions& options);

// A point on a straight line: at rest, moving for ever, or as its schedule says; or one that sways
// about that line.
struct ScenePoint {
  int track = 0;
  Eigen::Vector3d position;  // W, at time 0; of a scheduled one, before it ever moved [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // W, at full speed
  int from_frame = 0;                                  // not seen before
  std::optional<Schedule> schedule = std::nullopt;
  std::optional<Manoeuvre> manoeuvre = std::nullopt;

  double travelled(double time) const { return schedule ? schedule->travelled(time) : time; }
  Eigen::Vector3d at(double time) const {
    const Eigen::Vector3d on_line = position + velocity * travelled(time);
    return manoeuvre ? Eigen::Vector3d(on_line + manoeuvre->offset(time)) : on_line;
  }
  Eigen::Vector3d velocity_at(double time) const {
    const Eigen::Vector3d on_line =
        schedule ? Eigen::Vector3d(velocity * schedule->pace(time)) : velocity;
    return manoeuvre ? Eigen::Vector3d(on_line + manoeuvre->velocity(time)) : on_line;
  }
  Label label() const { return velocity.isZero(0.0) ? Label::kStatic : Label::kMoving; }
};

// Pinhole with square pixels and the principal point in the middle.
Camera simulated_camera(const RecordingOptions& options);

// The noise-free pixel of a point that is seen.
std::optional<Eigen::Vector2d> view(const Camera& camera, const RecordingOptions& options,
                                    const CameraState& from, const Eigen::Vector3d& point);

// A sequence without frames: camera and pixel sigma.
Sequence blank_sequence(const RecordingOptions& options);

// What a camera on `trajectory` (one state a frame) sees of points with increasing tracks.
// Landmarks that are never seen have no truth.
Sequence record(const RecordingOptions& options, const std::vector<CameraState>& trajectory,
                const std::vector<ScenePoint>& points, std::uint64_t seed);

}  // namespace slammot
