// The scene `basement`: the thesis's real experiment (4.1.2) with a truth. A room of 15.2 x 11.3 m
// with desks, cabinets and pillars; a robot drives round an ellipse and past its start; a person
// walks through its view three times.
//
// Lap and passages are parts of the run: with fewer frames at the same rate the robot drives
// faster, and the person does not.
#include <cmath>
#include <numbers>

#include "frontend/rendering/room.h"

namespace slammot {
namespace {

constexpr double kWidth = 15.2, kDepth = 11.3;    // x, z [m]
constexpr double kFloor = 1.0, kCeiling = -1.8;   // below and above the camera: y is down [m]
constexpr double kRadiusX = 4.2, kRadiusZ = 2.2;  // of the path [m]
constexpr double kLap = 0.92;                     // of the run, until the start is passed again
constexpr double kPassages[] = {330.0 / 1793.0, 950.0 / 1793.0, 1350.0 / 1793.0};  // thesis 4.5

double duration(const RoomOptions& options) { return options.frames / options.rate; }

// Round the centre (kRadiusX, 0, 0), looking along the path.
CameraState on_ellipse(double time, double lap) {
  const double rate = 2.0 * std::numbers::pi / lap, phase = rate * time;
  const double s = std::sin(phase), c = std::cos(phase);
  const double vx = kRadiusX * s, vz = kRadiusZ * c;  // over the rate
  CameraState state;
  state.position = {kRadiusX * (1.0 - c), 0.0, kRadiusZ * s};
  state.velocity = {rate * vx, 0.0, rate * vz};
  state.orientation = exp_so3(Eigen::Vector3d(0.0, std::atan2(vx, vz), 0.0));
  state.angular_velocity = {0.0, rate * kRadiusX * kRadiusZ / (vx * vx + vz * vz), 0.0};
  return state;
}

// Stands on the floor.
RoomBox standing(double x, double z, const Eigen::Vector3d& size, std::uint32_t texture) {
  return box_at({x, kFloor - size.y() / 2.0, z}, size, texture);
}

std::vector<RoomBox> furniture(RandomStream& random) {
  std::vector<RoomBox> boxes;
  std::uint32_t texture = 0;
  const auto add = [&](double x, double z, const Eigen::Vector3d& size) {
    boxes.push_back(standing(x + random.uniform(-0.15, 0.15), z + random.uniform(-0.15, 0.15), size,
                             ++texture));
  };
  const double left = kRadiusX - kWidth / 2.0;
  for (const double side : {-1.0, 1.0}) {
    const double wall = side * kDepth / 2.0;
    for (int k = 0; k < 4; ++k) {
      const double x = left + 1.9 + 3.8 * k;
      add(x, wall - side * 0.6, {1.6, 0.75, 0.8});                            // a desk
      add(x + 1.9, wall - side * 0.4, {0.9, random.uniform(1.2, 2.2), 0.5});  // a cabinet
      add(x, wall - side * 0.5, {0.5, 1.25, 0.4});  // what stands on the desk
    }
    for (int k = 0; k < 3; ++k) {
      const double x = kRadiusX + side * (kWidth / 2.0 - 0.5);
      add(x, -3.2 + 3.2 * k, {0.7, random.uniform(0.8, 2.2), 1.2});
    }
    add(kRadiusX + side * 6.2, side * 3.4, {0.4, kFloor - kCeiling, 0.4});  // a pillar
    add(kRadiusX + side * 1.4, 0.0, {0.4, kFloor - kCeiling, 0.4});         // within the loop
  }
  return boxes;
}

// 1.75 m tall, its feet at `foot` at time 0. Rigid: legs and arms do not swing.
std::vector<RoomBox> person(const Eigen::Vector3d& foot, std::uint32_t texture) {
  struct Part {
    Eigen::Vector3d above_foot, size;  // centre
  };
  const Part parts[] = {
      {{-0.1, 0.42, 0.0}, {0.17, 0.84, 0.2}},  {{0.1, 0.42, 0.0}, {0.17, 0.84, 0.2}},
      {{0.0, 1.13, 0.0}, {0.42, 0.6, 0.26}},   {{0.0, 1.6, 0.0}, {0.2, 0.28, 0.22}},
      {{-0.28, 1.1, 0.0}, {0.12, 0.66, 0.16}}, {{0.28, 1.1, 0.0}, {0.12, 0.66, 0.16}}};
  std::vector<RoomBox> boxes;
  for (const Part& part : parts) {
    const Eigen::Vector3d up(part.above_foot.x(), -part.above_foot.y(), part.above_foot.z());
    boxes.push_back(box_at(foot + up, part.size, texture++));
  }
  return boxes;
}

// Across the view from one side to the other, from wall to wall: what is beyond the walls nobody
// sees.
std::vector<RoomBox> passage(const RoomOptions& options, int k, RandomStream& random) {
  const double middle = kPassages[k % 3] * duration(options);
  const CameraState camera = on_ellipse(middle, kLap * duration(options));
  const double distance = random.uniform(2.3, 3.0), side = k % 2 == 0 ? 1.0 : -1.0;
  const double speed = options.body_speed * random.uniform(0.9, 1.1);
  const Eigen::Vector3d velocity = camera.orientation * Eigen::Vector3d(side * speed, 0.0, 0.0);
  Eigen::Vector3d foot = camera.position + camera.orientation * Eigen::Vector3d(0.0, 0.0, distance);
  foot.y() = kFloor;
  const double half = kWidth / speed;
  std::vector<RoomBox> boxes =
      person(foot - velocity * middle, static_cast<std::uint32_t>(100 + 10 * k));
  for (RoomBox& box : boxes) {
    box.velocity = velocity;
    box.from = middle - half;
    box.to = middle + half;
  }
  return boxes;
}

}  // namespace

RoomOptions basement_options() {
  RoomOptions options;
  options.scene = RoomScene::kBasement;
  options.frames = 1793;
  options.rate = 13.0;
  options.width = 640;
  options.height = 480;
  options.samples = 1;
  return options;
}

RoomPlan basement(const RoomOptions& options, RandomStream& random) {
  RoomPlan plan;
  plan.walls =
      box_at({kRadiusX, (kFloor + kCeiling) / 2.0, 0.0}, {kWidth, kFloor - kCeiling, kDepth}, 0);
  plan.boxes = furniture(random);
  for (int k = 0; k < options.bodies; ++k) {
    const std::vector<RoomBox> body = passage(options, k, random);
    plan.boxes.insert(plan.boxes.end(), body.begin(), body.end());
  }
  const double lap = kLap * duration(options);
  plan.camera_at = [lap](double time) { return on_ellipse(time, lap); };
  return plan;
}

}  // namespace slammot
