#include "datasets/simulation/matched.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <stdexcept>

#include "datasets/simulation/random/random_stream.h"
#include "datasets/simulation/scene/second_view.h"
#include "models/camera_motion.h"

namespace slammot {

Parameters parameters(MatchedOptions& o) {
  return joined(
      {{"visible", "landmarks in every frame", &o.visible, 1},
       {"moving_fraction", "of the landmarks born after frame 0", &o.moving_fraction, 0},
       {"known", "landmarks of frame 0 known beforehand", &o.known, 0},
       {"known_sigma", "of each axis [m]", &o.known_sigma, kAbove0},
       {"inverse_depth", "mean at birth [1/m]", &o.prior.inverse_depth, kAbove0},
       {"inverse_depth_sigma", "at birth [1/m]", &o.prior.inverse_depth_sigma, kAbove0},
       {"max_speed", "twice the sigma of a velocity at birth [m/s]", &o.prior.max_speed, kAbove0},
       {"object_acceleration", "sigma of moving landmarks [m/s^2]", &o.prior.acceleration, 0},
       {"acceleration", "sigma of the camera [m/s^2]", &o.motion.acceleration, kAbove0},
       {"angular_acceleration", "sigma of the camera [rad/s^2]", &o.motion.angular_acceleration,
        kAbove0},
       {"impulse", "1: the camera's noise is an impulse of (v, omega) before each step; 0: white",
        &o.impulse, 0},
       {"initial_speed", "forward, mean [m/s]", &o.initial.state.velocity.z(), -100},
       {"initial_position_sigma", "[m]", &o.initial.position_sigma, kAbove0},
       {"initial_rotation_sigma", "[rad]", &o.initial.rotation_sigma, kAbove0},
       {"initial_velocity_sigma", "[m/s]", &o.initial.velocity_sigma, kAbove0},
       {"initial_angular_velocity_sigma", "[rad/s]", &o.initial.angular_velocity_sigma, kAbove0}},
      parameters(o.recording));
}

namespace {

CameraState draw_first(const InitialCamera& initial, RandomStream& random) {
  const Vector12d error = random.normals<kCameraDim>().cwiseProduct(initial.sigmas());
  return boxplus(initial.state, error);
}

CameraState after_white_noise(const StatedMotion& motion, const CameraState& x, double dt,
                              RandomStream& random) {
  const MotionNoise noise{motion.acceleration, motion.angular_acceleration,
                          NoiseDiscretisation::kWhiteNoise};
  const Matrix12d L = camera_noise(noise, x, dt).llt().matrixL();
  const Vector12d w = L * random.normals<kCameraDim>();
  return boxplus(predict(x, dt), w);
}

// (V, Omega) of Montiel et al. 2006 on the velocities, and then the step.
CameraState after_impulse(const StatedMotion& motion, const CameraState& x, double dt,
                          RandomStream& random) {
  CameraState pushed = x;
  pushed.velocity += motion.acceleration * dt * random.normals<3>();
  pushed.angular_velocity += motion.angular_acceleration * dt * random.normals<3>();
  return predict(pushed, dt);
}

std::vector<CameraState> draw_trajectory(const MatchedOptions& options, std::uint64_t seed) {
  RandomStream random(seed, "camera");
  const double dt = options.recording.dt();
  const auto next = options.impulse == 1 ? &after_impulse : &after_white_noise;
  std::vector<CameraState> trajectory{draw_first(options.initial, random)};
  while (static_cast<int>(trajectory.size()) < options.recording.frames) {
    trajectory.push_back(next(options.motion, trajectory.back(), dt, random));
  }
  return trajectory;
}

// A landmark in view.
struct LivePoint {
  int track;
  Eigen::Vector3d position;
  Eigen::Vector3d velocity;
  Label label;
};

class MatchedScene {
 public:
  MatchedScene(const MatchedOptions& options, std::uint64_t seed)
      : options_(options),
        points_(seed, "points"),
        objects_(seed, "objects"),
        pixels_(seed, "pixels"),
        sequence_(blank_sequence(options.recording)) {
    sequence_.motion = options.motion;
    sequence_.prior = options.prior;
    sequence_.initial = options.initial;
    const Eigen::Matrix2d pattern = white_noise_pattern(options.recording.dt());
    noise_factor_ = options.prior.acceleration * Eigen::Matrix2d(pattern.llt().matrixL());
  }

  void add_frame(const CameraState& camera) {
    const int index = static_cast<int>(sequence_.frames.size());
    sequence_.frames.push_back({index, options_.recording.time(index), {}, {}});
    sequence_.truth.emplace_back(camera);
    if (index == 0) {
      add_known();
    } else {
      move_points();
    }
    remove_unseen(camera);
    while (static_cast<int>(live_.size()) < options_.visible) add_point(camera);
    measure(camera);
  }

  Sequence result() && { return std::move(sequence_); }

 private:
  Eigen::Vector2d draw_pixel() {
    const double u = points_.uniform(-0.5, options_.recording.width - 0.5);
    const double v = points_.uniform(-0.5, options_.recording.height - 0.5);
    return {u, v};
  }

  // From a uniform pixel and an inverse distance ~ N(rho0, sigma_rho^2), without those nearer than
  // can be seen (6 sigma away by default).
  Eigen::Vector3d draw_position(const CameraState& camera) {
    const auto drawn = [&]() -> Eigen::Vector3d {
      const Eigen::Vector3d ray = sequence_.camera.unproject(draw_pixel())->ray.normalized();
      const double rho =
          options_.prior.inverse_depth + options_.prior.inverse_depth_sigma * points_.normal();
      return camera.position + camera.orientation * (ray / rho);
    };
    Eigen::Vector3d position = drawn();
    while (!seen(camera, position)) position = drawn();
    return position;
  }

  std::optional<Eigen::Vector2d> seen(const CameraState& camera, const Eigen::Vector3d& p) const {
    return view(sequence_.camera, options_.recording, camera, p);
  }

  // What is stated is drawn in view of the stated camera; where it truly is, from what is stated.
  void add_known() {
    for (int i = 0; i < options_.known; ++i) {
      const Eigen::Vector3d stated = draw_position(options_.initial.state);
      sequence_.known.push_back({next_track_, stated, options_.known_sigma});
      const Eigen::Vector3d error = options_.known_sigma * points_.normals<3>();
      live_.push_back({next_track_++, stated + error, Eigen::Vector3d::Zero(), Label::kStatic});
    }
  }

  void add_point(const CameraState& camera) {
    LivePoint point{next_track_++, draw_position(camera), Eigen::Vector3d::Zero(), Label::kStatic};
    const bool later = sequence_.frames.size() > 1;
    if (later && points_.uniform(0.0, 1.0) < options_.moving_fraction) {
      point.label = Label::kMoving;
      point.velocity = options_.prior.velocity_sigma() * points_.normals<3>();
    }
    live_.push_back(point);
  }

  void move_points() {
    for (LivePoint& point : live_) {
      if (point.label == Label::kStatic) continue;
      point.position += point.velocity * options_.recording.dt();
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector2d w = noise_factor_ * objects_.normals<2>();
        point.position(axis) += w(0);
        point.velocity(axis) += w(1);
      }
    }
  }

  void remove_unseen(const CameraState& camera) {
    std::erase_if(live_, [&](const LivePoint& p) { return !seen(camera, p.position); });
  }

  void measure(const CameraState& camera) {
    Frame& frame = sequence_.frames.back();
    for (const LivePoint& point : live_) {
      const Eigen::Vector2d error = options_.recording.noise * pixels_.normals<2>();
      frame.observations.push_back({point.track, *seen(camera, point.position) + error});
      TrueLandmark& truth = sequence_.landmarks[point.track];
      truth.label = point.label;
      if (point.label == Label::kMoving || truth.by_frame.empty()) {
        truth.by_frame[frame.index] = {point.position, point.velocity};
      }
    }
  }

  const MatchedOptions& options_;
  RandomStream points_, objects_, pixels_;
  Sequence sequence_;
  Eigen::Matrix2d noise_factor_;  // of (position, velocity) of a moving landmark in a step
  std::vector<LivePoint> live_;
  int next_track_ = 0;
};

}  // namespace

Sequence simulate_matched(const MatchedOptions& options, std::uint64_t seed) {
  if (options.impulse > 1) throw std::invalid_argument("impulse: must be 0 or 1");
  MatchedScene scene(options, seed);
  for (const CameraState& camera : draw_trajectory(options, seed)) scene.add_frame(camera);
  Sequence sequence = std::move(scene).result();
  add_second_view(options.recording, seed, sequence);
  add_depths(options.recording, seed, sequence);
  return sequence;
}

}  // namespace slammot
