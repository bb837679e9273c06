// A room to be rendered: textured walls, boxes that stand in it and boxes that move through it, and
// the path of a camera. Everything is exact, so that truth is known for whatever the front end
// picks out. There are two plans: `room`, small and seen from one end, and `basement`, as large as
// that of the thesis's real experiment (4.1.2), with a loop and a person (basement.cpp).
//
// World W: y down, the camera starts at the origin and looks along z. Boxes have their sides along
// the axes and move at constant velocity; their texture is solid (a function of the place within
// the box), so it moves with them and needs no unwrapping.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <limits>
#include <string_view>
#include <vector>

#include "datasets/simulation/parameters/parameters.h"
#include "datasets/simulation/random/random_stream.h"
#include "models/camera_state.h"
#include "models/rig.h"

namespace slammot {

enum class RoomScene { kRoom, kBasement };
std::string_view name_of(RoomScene scene);

struct RoomOptions {
  RoomScene scene = RoomScene::kRoom;
  int frames = 75;
  double rate = 15.0;  // [Hz]
  int width = 320, height = 240;
  double field_of_view_deg = 79.48;  // horizontal, of the pinhole
  double k1 = 0.0, k2 = 0.0;         // radial distortion, as in radtan
  double blur = 0.7;                 // sigma of the optics' blur [px]
  double exposure = 0.0;             // [s]; the image is the mean over it: motion blur
  double grain = 2.0;                // sigma of the sensor's noise [grey levels]
  int samples = 2;                   // rays of a pixel along each side
  int bodies = 3;                    // that move; basement: how often the person passes
  double body_speed = 1.0;           // [m/s]
  double stereo = 0.0;               // baseline of a second camera [m]; 0: none
};
RoomOptions basement_options();  // its defaults: the thesis's camera
Parameters parameters(RoomOptions& options);
inline constexpr char kStereo[] = "stereo";  // a key of them

struct RoomBox {
  Eigen::AlignedBox3d at_start;  // W, at time 0
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  std::uint32_t texture = 0;
  // When it is in the room [s].
  double from = -std::numeric_limits<double>::infinity();
  double to = std::numeric_limits<double>::infinity();

  bool moves() const { return !velocity.isZero(0.0); }
};

struct RoomHit {
  double distance;           // along the ray, in its lengths
  const RoomBox* box;        // what was hit
  Eigen::Vector3d at_start;  // the point, where it was at time 0 (W)
};

RoomBox box_at(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, std::uint32_t texture);

// What a scene is made of. Textures are counted from 0; each seed adds its own number.
struct RoomPlan {
  RoomBox walls;  // seen from inside
  std::vector<RoomBox> boxes;
  std::function<CameraState(double time)> camera_at;
};
RoomPlan small_room(const RoomOptions& options, RandomStream& random);
RoomPlan basement(const RoomOptions& options, RandomStream& random);

class Room {
 public:
  Room(const RoomOptions& options, std::uint64_t seed);

  Camera camera() const;
  std::vector<MountedCamera> other_cameras() const;  // beside it
  CameraState camera_at(double time) const { return plan_.camera_at(time); }
  bool holds(const Eigen::Vector3d& point) const { return plan_.walls.at_start.contains(point); }
  // What a ray from inside the room meets first.
  RoomHit cast(const Eigen::Vector3d& from, const Eigen::Vector3d& ray, double time) const;

 private:
  RoomOptions options_;
  RoomPlan plan_;
};

// Brightness of a point, 0 to 255.
double brightness(const RoomHit& hit);

}  // namespace slammot
