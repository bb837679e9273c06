#include "datasets/native/native_settings.h"

#include "datasets/camera/camera_file.h"
#include "datasets/native/native_format.h"
#include "datasets/sequence/plausible.h"
#include "datasets/text/yaml_map.h"

namespace slammot {
namespace {

StatedMotion read_motion(YamlMap map) {
  const StatedMotion motion{map.positive("acceleration"), map.positive("angular_acceleration")};
  map.finish();
  return motion;
}

LandmarkPrior read_prior(YamlMap map) {
  LandmarkPrior prior;
  prior.inverse_depth = map.real("inverse_depth");
  prior.inverse_depth_sigma = map.positive("inverse_depth_sigma");
  if (map.has("mean_sigma")) prior.mean_sigma = map.positive("mean_sigma");
  prior.max_speed = map.positive("max_speed");
  if (map.has("acceleration")) prior.acceleration = map.real("acceleration");
  if (prior.acceleration < 0.0) map.refuse(map.take("acceleration"), "'acceleration' is negative");
  if (map.has("jerk")) prior.jerk = map.real("jerk");
  if (prior.jerk < 0.0) map.refuse(map.take("jerk"), "'jerk' is negative");
  map.finish();
  return prior;
}

void read_initial_sigmas(YamlMap map, InitialCamera& initial) {
  initial.position_sigma = map.positive("position");
  initial.rotation_sigma = map.positive("rotation");
  initial.velocity_sigma = map.positive("velocity");
  initial.angular_velocity_sigma = map.positive("angular_velocity");
  map.finish();
}

}  // namespace

void read_settings(const std::filesystem::path& file, const std::string& text, Sequence& sequence) {
  YamlMap map = load_yaml(file, text);
  if (map.text("format") != native::kFormat) {
    map.refuse(map.take("format"), fmt::format("'format' must be '{}'", native::kFormat));
  }
  sequence.name = map.text("name");
  if (const std::string fault = folder_name_fault(sequence.name); !fault.empty()) {
    map.refuse(map.take("name"), "'name' " + fault);  // of the folder of a run
  }
  if (map.has("cameras")) {
    if (map.has("camera")) map.refuse(map.take("camera"), "'camera' stands beside 'cameras'");
    sequence.other_cameras = read_rig(map, "cameras");
    sequence.camera = sequence.other_cameras.front().lens;
    sequence.other_cameras.erase(sequence.other_cameras.begin());
  } else {
    sequence.camera = read_camera(map.map("camera"));
  }
  sequence.pixel_sigma = map.positive("pixel_sigma");
  if (map.has("motion")) sequence.motion = read_motion(map.map("motion"));
  if (map.has("prior")) sequence.prior = read_prior(map.map("prior"));
  if (map.has("points")) sequence.points = map.positive_integer("points");
  map.finish();
}

InitialCamera read_initial(const std::filesystem::path& file, const std::string& text) {
  YamlMap map = load_yaml(file, text);
  InitialCamera initial;
  initial.state.position = map.vector<3>("position");
  const Eigen::Quaterniond q(map.vector<4>("quaternion"));
  if (const Fault fault = quaternion_fault(q)) map.refuse(map.take("quaternion"), *fault);
  initial.state.orientation = unit_quaternion(q);
  initial.state.velocity = map.vector<3>("velocity");
  initial.state.angular_velocity = map.vector<3>("angular_velocity");
  read_initial_sigmas(map.map("sigma"), initial);
  map.finish();
  return initial;
}

Eigen::Quaterniond unit_quaternion(const Eigen::Quaterniond& q) {
  constexpr double kRounding = 1e-15;
  return std::abs(q.squaredNorm() - 1.0) < kRounding ? q : q.normalized();
}

Eigen::Quaterniond unit_quaternion(const TextTable& table, const Eigen::Quaterniond& q) {
  table.refuse_if(quaternion_fault(q));
  return unit_quaternion(q);
}

}  // namespace slammot
