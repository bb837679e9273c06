#include "bench/corridor.h"

#include <cmath>

#include "datasets/simulation/random/random_stream.h"
#include "models/points/observation.h"

namespace slammot::bench {

namespace {

constexpr double kPeriod = 1.0 / 15.0;  // [s]
constexpr double kPixelSigma = 1.0;     // [px]
constexpr double kHalfView = 6.0;       // that the camera sees at middle depth, along x [m]

struct Point {
  Eigen::Vector3d position, velocity;  // at time 0
};

CameraState camera_at(double t, double speed) {
  CameraState camera;
  camera.position = {speed * t, 0.1 * std::sin(t), 0.1 * std::cos(t)};
  camera.velocity = {speed, 0.1 * std::cos(t), -0.1 * std::sin(t)};
  return camera;
}

// Half as many again as are measured: there is always one waiting to be born.
std::vector<Point> points(const CorridorOptions& options, RandomStream& random) {
  const double length = options.speed * kPeriod * options.frames + 2.0 * kHalfView;
  const auto count = static_cast<int>(1.5 * options.visible * length / (2.0 * kHalfView));
  std::vector<Point> points;
  for (int i = 0; i < count; ++i) {
    const double x = -kHalfView + length * i / count;
    Point point{{x, random.uniform(-2.5, 2.5), random.uniform(4.0, 10.0)}, Eigen::Vector3d::Zero()};
    if (random.uniform(0.0, 1.0) < options.moving_fraction) {
      const double heading = random.uniform(0.0, 6.28), t_passed = x / options.speed;
      point.velocity = random.uniform(0.5, 1.5) *
                       Eigen::Vector3d(std::sin(heading), 0.0, 0.2 * std::cos(heading));
      point.position -= t_passed * point.velocity;
    }
    points.push_back(point);
  }
  return points;
}

Setup corridor_setup(double speed) {
  Setup setup;
  setup.camera.fx = setup.camera.fy = 400.0;
  setup.camera.cx = 319.5;
  setup.camera.cy = 239.5;
  setup.pixel_sigma = kPixelSigma;
  setup.camera_noise = {0.3, 0.1, NoiseDiscretisation::kWhiteNoise};
  setup.prior = {0.15, 0.04, 0.0, 2.0, 0.1};
  setup.prior.steady_time = 0.0;
  setup.initial.state = camera_at(0.0, speed);
  setup.initial.velocity_sigma = 0.1;
  setup.initial.angular_velocity_sigma = 0.1;
  return setup;
}

}  // namespace

Corridor make_corridor(const CorridorOptions& options) {
  RandomStream world(1, "points"), pixels(1, "pixels");
  const std::vector<Point> all = points(options, world);
  Corridor corridor{corridor_setup(options.speed), {}, {}};
  const Camera& camera = corridor.setup.camera;
  for (int k = 0; k < options.frames; ++k) {
    const double t = k * kPeriod;
    const CameraState at = camera_at(t, options.speed);
    Frame frame{k, t, {}, {}};
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Eigen::Vector3d ray = all[i].position + t * all[i].velocity - at.position;
      const auto seen = camera.project(ray);
      if (!seen || !camera.in_image(seen->pixel)) continue;
      frame.observations.push_back(
          {static_cast<int>(i), seen->pixel + kPixelSigma * pixels.normals<2>()});
      if (k == 0) {
        corridor.setup.known.push_back({static_cast<int>(i), all[i].position, 1e-3});
      }
    }
    corridor.frames.push_back(std::move(frame));
    corridor.truth.push_back(at);
  }
  corridor.setup.known.resize(std::min<std::size_t>(corridor.setup.known.size(), 4));
  return corridor;
}

Configuration thesis_configuration(const CorridorOptions& options) {
  Configuration configuration;
  assign(configuration, {"preset", "thesis"});
  configuration.model.policy.max_visible = options.visible;
  configuration.model.policy.max_landmarks = 100000;
  return configuration;
}

}  // namespace slammot::bench
