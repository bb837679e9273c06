#include "datasets/simulation/scene/volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "datasets/simulation/random/random_stream.h"
#include "datasets/simulation/scene/mover_sigmas.h"

namespace slammot {

Parameters parameters(VolumeOptions& o) {
  return {
      {"static", "number of static points", &o.static_points, 0},
      {"moving", "number of moving points", &o.moving_points, 0},
      {"first_static", "static points placed in view of frame 0", &o.first_static, 0},
      {"first_moving",
       "moving points allowed in view of frame 0; -1: as many as the draw puts there",
       &o.first_moving, -1},
      {"volume_width", "of the points, x and z [m]", &o.width, kAbove0},
      {"volume_height", "of the points, y [m]", &o.height, kAbove0},
      {"min_speed", "of moving points [m/s]", &o.min_speed, kAbove0},
      {"max_speed", "of moving points [m/s]", &o.max_speed, kAbove0},
      {"max_climb", "of moving points against the horizontal [deg]", &o.max_climb_deg, 0},
  };
}

Parameters parameters(SceneOptions& o) {
  return joined(
      joined(joined(parameters(o.recording), parameters(o.volume)),
             parameters(o.volume.manoeuvres)),
      joined(joined(parameters(o.known), parameters(o.statements)), parameters(o.disturbances)));
}

namespace {

constexpr int kTries = 10000;  // to place a point that is, or is not, in view of the first frame

struct Volume {
  const SceneOptions& options;
  Eigen::Vector3d centre;
  Camera camera;
  CameraState first;

  Eigen::Vector3d draw(RandomStream& random) const {
    const double x = random.uniform(-0.5, 0.5);
    const double y = random.uniform(-0.5, 0.5);
    const double z = random.uniform(-0.5, 0.5);
    const VolumeOptions& v = options.volume;
    return centre + Eigen::Vector3d(x * v.width, y * v.height, z * v.width);
  }
  bool in_first_frame(const ScenePoint& point) const {
    return view(camera, options.recording, first, point.at(0.0)).has_value();
  }
};

void add_static(const Volume& volume, RandomStream& random, std::vector<ScenePoint>& points) {
  const VolumeOptions& options = volume.options.volume;
  for (int i = 0; i < options.static_points; ++i) {
    ScenePoint point{i, volume.draw(random)};
    for (int k = 0; i < options.first_static && k < kTries && !volume.in_first_frame(point); ++k) {
      point.position = volume.draw(random);
    }
    points.push_back(point);
  }
}

Eigen::Vector3d draw_velocity(const VolumeOptions& options, RandomStream& random) {
  const double speed = random.uniform(options.min_speed, options.max_speed);
  const double azimuth = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double limit = options.max_climb_deg * std::numbers::pi / 180.0;
  const double climb = random.uniform(-limit, limit);
  return speed * Eigen::Vector3d(std::cos(climb) * std::sin(azimuth), -std::sin(climb),
                                 std::cos(climb) * std::cos(azimuth));
}

// Each has a stream of its own: with and without stops or manoeuvres, objects are the same
// otherwise.
struct MoverStreams {
  RandomStream points, schedules, manoeuvres;
};

ScenePoint draw_moving(const Volume& volume, int track, MoverStreams& random) {
  const RecordingOptions& recording = volume.options.recording;
  const double duration = recording.time(recording.frames);
  const VolumeOptions& options = volume.options.volume;
  ScenePoint point{track, volume.draw(random.points), draw_velocity(options, random.points)};
  point.schedule = draw_schedule(options.stops, duration, random.schedules);
  const auto manoeuvre = draw_manoeuvre(options.manoeuvres, point.velocity, random.manoeuvres);
  if (!point.schedule) point.manoeuvre = manoeuvre;
  const double passing = random.points.uniform(0.0, duration);
  point.position -= point.velocity * point.travelled(passing);
  if (point.manoeuvre) point.position -= point.manoeuvre->offset(passing);
  return point;
}

void add_moving(const Volume& volume, MoverStreams& random, std::vector<ScenePoint>& points) {
  const VolumeOptions& options = volume.options.volume;
  int in_first_frame = 0;
  for (int i = 0; i < options.moving_points; ++i) {
    const int track = options.static_points + i;
    ScenePoint point = draw_moving(volume, track, random);
    for (int k = 0;
         k < kTries && in_first_frame == options.first_moving && volume.in_first_frame(point);
         ++k) {
      point = draw_moving(volume, track, random);
    }
    if (volume.in_first_frame(point)) ++in_first_frame;
    points.push_back(point);
  }
}

std::vector<ScenePoint> draw_points(const SceneOptions& options, const Eigen::Vector3d& centre,
                                    const CameraState& first, std::uint64_t seed) {
  const Volume volume{options, centre, simulated_camera(options.recording), first};
  std::vector<ScenePoint> points;
  RandomStream static_points(seed, "static points");
  MoverStreams movers{{seed, "moving points"}, {seed, "schedules"}, {seed, "manoeuvres"}};
  add_static(volume, static_points, points);
  add_moving(volume, movers, points);
  return points;
}

// From ten times as many points, another seed, and no more than the frames of a usual run.
LandmarkPrior population_prior(SceneOptions options, const Eigen::Vector3d& centre,
                               const std::vector<CameraState>& trajectory) {
  constexpr std::uint64_t kSeed = 0;
  constexpr int kFrames = 600, kTimes = 10;
  RecordingOptions& recording = options.recording;
  VolumeOptions& volume = options.volume;
  const double usual = std::min(1.0, static_cast<double>(kFrames) / recording.frames);
  recording.frames = std::min(recording.frames, kFrames);
  volume.moving_points = static_cast<int>(volume.moving_points * usual) * kTimes;
  volume.static_points *= kTimes;
  LandmarkPrior prior = prior_of(record(
      recording, trajectory, draw_points(options, centre, trajectory.front(), kSeed), kSeed));
  const bool stops = volume.stops.stopping_fraction + volume.stops.parked_fraction > 0.0;
  if (volume.manoeuvres.share > 0.0 && !stops) {
    const MoverSigmas rms = rms_of_movers(volume);
    prior.acceleration = std::max(rms.acceleration, kLeastObjectAcceleration);
    prior.jerk = rms.jerk;
  }
  return prior;
}

void check(const VolumeOptions& options) {
  const ManoeuvreOptions& m = options.manoeuvres;
  if (m.share > 1.0) {
    throw std::invalid_argument(fmt::format("manoeuvring: must be at most 1, not {}", m.share));
  }
  const double slowing = largest_slowing(m);
  if (m.share > 0.0 && slowing >= options.min_speed) {
    throw std::invalid_argument(
        fmt::format("braking, manoeuvre_period: slow a mover by {:.3g} m/s, which must be less "
                    "than min_speed ({} m/s)",
                    slowing, options.min_speed));
  }
}

}  // namespace

Sequence simulate_in_volume(const SceneOptions& options, const Eigen::Vector3d& centre,
                            const std::vector<CameraState>& path, std::uint64_t seed) {
  check(options.volume);
  const std::vector<CameraState> trajectory = displaced(options.disturbances, path);
  const auto points = draw_points(options, centre, trajectory.front(), seed);
  Sequence sequence = record(options.recording, trajectory, points, seed);
  sequence.known = choose_known(options.known, sequence, seed);
  state(options.statements, population_prior(options, centre, path), seed, sequence);
  disturb(options.disturbances, seed, sequence);
  return sequence;
}

}  // namespace slammot
