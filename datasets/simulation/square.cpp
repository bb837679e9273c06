#include "datasets/simulation/square.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "datasets/simulation/path.h"

namespace slammot {

Parameters parameters(SquareOptions& o) {
  return joined({{"side", "of the square [m]", &o.side, kAbove0},
                 {"loop_frames", "frames of one loop", &o.loop_frames, 1},
                 {"turn_length", "length of the arc at a corner [m]", &o.turn_length, kAbove0}},
                parameters(o.scene));
}

namespace {

constexpr double kQuarter = std::numbers::pi / 2.0;

double turn_heading(double length, double w) {
  const double phase = 2.0 * std::numbers::pi * w / length;
  return kQuarter * (w / length - std::sin(phase) / (2.0 * std::numbers::pi));
}

double turn_curvature(double length, double w) {
  return kQuarter / length * (1.0 - std::cos(2.0 * std::numbers::pi * w / length));
}

// Where a corner leads after arc length w, from the origin along +z; Simpson's rule.
Eigen::Vector3d turn_position(double length, double w) {
  constexpr int kSteps = 200;
  const double step = w / kSteps;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i <= kSteps; ++i) {
    const double weight = i == 0 || i == kSteps ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
    sum += weight * heading_vector(turn_heading(length, i * step));
  }
  return sum * step / 3.0;
}

struct Square {
  double side;         // between opposite lines
  double turn_length;  // along the arc of a corner
  double turn_reach;   // how far a corner leads along either line

  double straight() const { return side - 2.0 * turn_reach; }
  double quarter() const { return straight() + turn_length; }

  PathPoint at(double distance, double speed) const {
    const double s = distance + straight() / 2.0;
    const double corners = std::floor(s / quarter());
    const double along = s - corners * quarter();
    const double w = std::max(along - straight(), 0.0);
    const Eigen::Vector3d centre(side / 2.0, 0.0, 0.0);
    const Eigen::Vector3d start(0.0, 0.0, std::min(along, straight()) - straight() / 2.0);
    const Eigen::Vector3d local = start + turn_position(turn_length, w) - centre;
    const double turned = kQuarter * std::fmod(corners, 4.0);
    const Eigen::AngleAxisd turn(turned, Eigen::Vector3d::UnitY());
    return {centre + turn * local, turned + turn_heading(turn_length, w), speed,
            speed * turn_curvature(turn_length, w)};
  }
};

}  // namespace

Sequence simulate_square(const SquareOptions& options, std::uint64_t seed) {
  const double reach = turn_position(options.turn_length, options.turn_length).z();
  const Square square{options.side, options.turn_length, reach};
  if (square.straight() < 0.0) {
    throw std::invalid_argument("turn_length: the corners do not fit on the side");
  }
  const RecordingOptions& recording = options.scene.recording;
  const double step = 4.0 * square.quarter() / options.loop_frames;
  std::vector<CameraState> trajectory;
  for (int i = 0; i < recording.frames; ++i) {
    trajectory.push_back(camera_on_path(square.at(i * step, step * recording.rate), 0.0));
  }
  return simulate_in_volume(options.scene, {options.side / 2.0, 0.0, 0.0}, trajectory, seed);
}

}  // namespace slammot
