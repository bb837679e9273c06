// The scene `room`: three boxes before the far wall, and bodies that cross from both sides.
#include <cmath>
#include <numbers>

#include "frontend/rendering/room.h"

namespace slammot {
namespace {

// Enters from the left or the right, outside the first image, at a depth of its own.
RoomBox moving_box(const RoomOptions& options, int k, RandomStream& random) {
  const double side = k % 2 == 0 ? -1.0 : 1.0;
  const double depth = random.uniform(2.2, 3.8);
  const double edge = depth * std::tan(options.field_of_view_deg / 360.0 * std::numbers::pi);
  const double size = random.uniform(0.5, 0.8);
  const int row = k / 2;
  const double outside = edge + size + 0.6 * row;
  RoomBox body = box_at({side * outside, random.uniform(-0.7, 0.7), depth},
                        Eigen::Vector3d::Constant(size), static_cast<std::uint32_t>(100 + k));
  body.velocity = {-side * options.body_speed, 0.0, random.uniform(-0.2, 0.2)};
  return body;
}

// To and fro before the far wall, slowly nearer, looking a little to the sides.
CameraState camera_at(double time) {
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

}  // namespace

RoomPlan small_room(const RoomOptions& options, RandomStream& random) {
  RoomPlan plan;
  plan.walls = box_at({0.0, 0.0, 2.5}, {11.0, 3.2, 9.0}, 0);
  plan.boxes.push_back(box_at({-1.6, 0.9, 4.2}, {0.9, 1.4, 0.9}, 1));
  plan.boxes.push_back(box_at({1.4, 0.6, 5.2}, {1.2, 2.0, 0.8}, 2));
  plan.boxes.push_back(box_at({0.3, -1.3, 3.6}, {0.8, 0.6, 0.8}, 3));
  for (int k = 0; k < options.bodies; ++k) plan.boxes.push_back(moving_box(options, k, random));
  plan.camera_at = camera_at;
  return plan;
}

}  // namespace slammot
