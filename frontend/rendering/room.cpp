#include "frontend/rendering/room.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/simulation/scene/second_view.h"

namespace slammot {

std::string_view name_of(RoomScene scene) {
  return scene == RoomScene::kBasement ? "basement" : "room";
}

RoomBox box_at(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, std::uint32_t texture) {
  RoomBox box;
  box.at_start = {centre - size / 2.0, centre + size / 2.0};
  box.texture = texture;
  return box;
}

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
      {"samples", "rays of a pixel, along each side", &o.samples, 1},
      {"bodies", "that move through the room; basement: passages of the person", &o.bodies, 0},
      {"body_speed", "[m/s]", &o.body_speed, kAbove0},
      {kStereo, "baseline of a second camera, to the right [m]; 0: none", &o.stereo, 0},
  };
}

namespace {

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
  plan_ = options.scene == RoomScene::kBasement ? basement(options, random)
                                                : small_room(options, random);
  plan_.walls.texture += base;
  for (RoomBox& box : plan_.boxes) box.texture += base;
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

std::vector<MountedCamera> Room::other_cameras() const {
  if (options_.stereo == 0.0) return {};
  return {camera_to_the_right(camera(), options_.stereo)};
}

RoomHit Room::cast(const Eigen::Vector3d& from, const Eigen::Vector3d& ray, double time) const {
  const RoomBox& walls = plan_.walls;
  RoomHit hit{inside(walls.at_start, from, ray).to, &walls, Eigen::Vector3d::Zero()};
  for (const RoomBox& candidate : plan_.boxes) {
    if (time < candidate.from || time > candidate.to) continue;
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
