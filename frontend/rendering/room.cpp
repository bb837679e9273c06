#include "frontend/rendering/room.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/simulation/scene/random_stream.h"

namespace slammot {

Parameters parameters(RoomOptions& o) {
  return {
      {"frames", "number of frames", &o.frames, 1},
      {"rate", "frames a second", &o.rate, kAbove0},
      {"width", "of the image [px]", &o.width, 32},
      {"height", "of the image [px]", &o.height, 32},
      {"field_of_view", "horizontal, without distortion [deg]", &o.field_of_view_deg, kAbove0},
      {"k1", "radial distortion, r^2", &o.k1, -1},
      {"k2", "radial distortion, r^4", &o.k2, -1},
      {"blur", "sigma of the optics' blur [px]", &o.blur, 0},
      {"exposure", "time over which an image is averaged [s]", &o.exposure, 0},
      {"grain", "sigma of the sensor's noise [grey levels]", &o.grain, 0},
      {"bodies", "that move through the room", &o.bodies, 0},
      {"body_speed", "[m/s]", &o.body_speed, kAbove0},
  };
}

namespace {

RoomBox box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, std::uint32_t texture) {
  return {{centre - size / 2.0, centre + size / 2.0}, Eigen::Vector3d::Zero(), texture};
}

// Enters from the left or the right, outside the first image, at a depth of its own.
RoomBox moving_box(const RoomOptions& options, int k, RandomStream& random) {
  const double side = k % 2 == 0 ? -1.0 : 1.0;
  const double depth = random.uniform(2.2, 3.8);
  const double edge = depth * std::tan(options.field_of_view_deg / 360.0 * std::numbers::pi);
  const double size = random.uniform(0.5, 0.8);
  const int row = k / 2;
  const double outside = edge + size + 0.6 * row;
  RoomBox body = box({side * outside, random.uniform(-0.7, 0.7), depth},
                     Eigen::Vector3d::Constant(size), static_cast<std::uint32_t>(100 + k));
  body.velocity = {-side * options.body_speed, 0.0, random.uniform(-0.2, 0.2)};
  return body;
}

struct Interval {
  double from, to;
};

// Where a ray is inside a box, by the three pairs of its sides.
Interval inside(const Eigen::AlignedBox3d& b, const Eigen::Vector3d& from,
                const Eigen::Vector3d& ray) {
  const Eigen::Array3d inverse = ray.array().inverse();  // infinite along a side: that is right
  const Eigen::Array3d a = (b.min() - from).array() * inverse;
  const Eigen::Array3d c = (b.max() - from).array() * inverse;
  return {a.min(c).maxCoeff(), a.max(c).minCoeff()};
}

// A number in [0, 1) for a place of a lattice.
double lattice(int x, int y, int z, std::uint32_t texture) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 374761393u +
                    static_cast<std::uint32_t>(y) * 668265263u +
                    static_cast<std::uint32_t>(z) * 2147483647u + texture * 3266489917u;
  h = (h ^ (h >> 13)) * 1274126177u;
  h = (h ^ (h >> 15)) * 2246822519u;
  return (h ^ (h >> 16)) / 4294967296.0;
}

// Smooth between the places of the lattice (value noise, Perlin 1985).
double noise(const Eigen::Vector3d& p, std::uint32_t texture) {
  const Eigen::Array3d cell = p.array().floor();
  const Eigen::Array3d t = p.array() - cell;
  const Eigen::Array3d s = t * t * (3.0 - 2.0 * t);
  const Eigen::Array3i i = cell.cast<int>();
  double sum = 0.0;
  for (int k = 0; k < 8; ++k) {
    const int x = k & 1, y = (k >> 1) & 1, z = (k >> 2) & 1;
    const double weight =
        (x != 0 ? s(0) : 1.0 - s(0)) * (y != 0 ? s(1) : 1.0 - s(1)) * (z != 0 ? s(2) : 1.0 - s(2));
    sum += weight * lattice(i(0) + x, i(1) + y, i(2) + z, texture);
  }
  return sum;
}

}  // namespace

Room::Room(const RoomOptions& options, std::uint64_t seed) : options_(options) {
  RandomStream random(seed, "room");
  const auto base = static_cast<std::uint32_t>(random.below(1 << 30));
  walls_ = box({0.0, 0.0, 2.5}, {11.0, 3.2, 9.0}, base);
  boxes_.push_back(box({-1.6, 0.9, 4.2}, {0.9, 1.4, 0.9}, base + 1));
  boxes_.push_back(box({1.4, 0.6, 5.2}, {1.2, 2.0, 0.8}, base + 2));
  boxes_.push_back(box({0.3, -1.3, 3.6}, {0.8, 0.6, 0.8}, base + 3));
  for (int k = 0; k < options.bodies; ++k) {
    boxes_.push_back(moving_box(options, k, random));
    boxes_.back().texture += base;
  }
}

Camera Room::camera() const {
  Camera camera;
  camera.width = options_.width;
  camera.height = options_.height;
  const double half_angle = options_.field_of_view_deg / 360.0 * std::numbers::pi;
  camera.fx = camera.fy = options_.width / 2.0 / std::tan(half_angle);
  camera.cx = (options_.width - 1) / 2.0;
  camera.cy = (options_.height - 1) / 2.0;
  if (options_.k1 != 0.0 || options_.k2 != 0.0) {
    camera.lens = RadtanLens{{options_.k1, options_.k2, 0.0, 0.0, 0.0}};
  }
  return camera;
}

// To and fro before the far wall, slowly nearer, looking a little to the sides.
CameraState Room::camera_at(double time) const {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double a = kTurn / 5.0, b = kTurn / 7.0, c = kTurn / 6.0;  // [rad/s]
  CameraState state;
  state.position = {0.8 * std::sin(a * time), 0.15 * (1.0 - std::cos(b * time)), 0.12 * time};
  state.velocity = {0.8 * a * std::cos(a * time), 0.15 * b * std::sin(b * time), 0.12};
  const double yaw = -0.15 * std::sin(c * time);
  state.orientation = exp_so3(Eigen::Vector3d(0.0, yaw, 0.0));
  state.angular_velocity = {0.0, -0.15 * c * std::cos(c * time), 0.0};
  return state;
}

RoomHit Room::cast(const Eigen::Vector3d& from, const Eigen::Vector3d& ray, double time) const {
  RoomHit hit{inside(walls_.at_start, from, ray).to, &walls_, Eigen::Vector3d::Zero()};
  for (const RoomBox& candidate : boxes_) {
    const Interval interval = inside(candidate.at_start, from - candidate.velocity * time, ray);
    if (interval.from > interval.to || interval.from <= 0.0 || interval.from >= hit.distance) {
      continue;
    }
    hit.distance = interval.from;
    hit.box = &candidate;
  }
  hit.at_start = from + hit.distance * ray - hit.box->velocity * time;
  return hit;
}

double brightness(const RoomHit& hit) {
  constexpr double kCoarse = 0.35, kMiddle = 0.14, kFine = 0.06;  // [m]
  const Eigen::Vector3d p = hit.at_start - hit.box->at_start.min();
  const std::uint32_t t = hit.box->texture;
  const double value = 0.4 * noise(p / kCoarse, t) + 0.35 * noise(p / kMiddle, t + 7919) +
                       0.25 * noise(p / kFine, t + 104729);
  // More contrast than a sum of noises has.
  return 255.0 * std::clamp(0.5 + 1.7 * (value - 0.5), 0.0, 1.0);
}

}  // namespace slammot
