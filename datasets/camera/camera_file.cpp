#include "datasets/camera/camera_file.h"

#include <algorithm>

#include "datasets/sequence/plausible.h"

namespace slammot {
namespace {

// What is wrong is wrong at `key`.
Camera with_lens(YamlMap& map, const std::string& key, Camera camera, std::string_view lens,
                 const std::vector<double>& distortion) {
  try {
    camera.lens = make_lens(lens, distortion);
  } catch (const std::invalid_argument& error) {
    map.refuse(map.take(key), error.what());
  }
  if (const Fault fault = camera_fault(camera)) map.refuse(map.take(key), *fault);
  return camera;
}

std::vector<double> list_if_any(YamlMap& map, const std::string& key) {
  return map.has(key) ? map.list(key) : std::vector<double>{};
}

// As the camera of sequence.yaml; the map may hold more.
Camera take_camera(YamlMap& map) {
  Camera camera;
  const std::string model = map.text("model");
  camera.width = map.positive_integer("width");
  camera.height = map.positive_integer("height");
  camera.fx = map.positive("fx");
  camera.fy = map.positive("fy");
  camera.cx = map.real("cx");
  camera.cy = map.real("cy");
  camera = with_lens(map, "model", camera, model, list_if_any(map, "distortion"));
  return camera;
}

struct Pose {
  Eigen::Vector3d position;
  Eigen::Quaterniond orientation;
};

Pose read_pose(YamlMap map) {
  Pose pose{map.vector<3>("position"), Eigen::Quaterniond(map.vector<4>("quaternion"))};
  if (const Fault fault = quaternion_fault(pose.orientation)) {
    map.refuse(map.take("quaternion"), *fault);
  }
  pose.orientation.normalize();
  map.finish();
  return pose;
}

MountedCamera first_camera(YamlMap& map, const Camera& camera) {
  constexpr double kRounding = 1e-9;
  if (!map.has("T_C0_C")) return camera;
  const Pose pose = read_pose(map.map("T_C0_C"));
  const double turned = pose.orientation.angularDistance(Eigen::Quaterniond::Identity());
  if (pose.position.norm() > kRounding || turned > kRounding) {
    map.refuse(map.take("T_C0_C"), "'T_C0_C' of camera 0 is the identity");
  }
  return camera;
}

MountedCamera mounted_camera(YamlMap& map, const Camera& camera) {
  const Pose pose = read_pose(map.map("T_C0_C"));
  return {camera, pose.orientation, pose.position};
}

// What is wrong of the newest beside the others.
void refuse_rig(const YamlMap& map, const YAML::Node& at, const std::vector<MountedCamera>& rig) {
  constexpr double kLeastBaseline = 1e-4;  // [m]
  const MountedCamera& newest = rig.back();
  for (std::size_t i = 0; i + 1 < rig.size(); ++i) {
    if ((newest.t - rig[i].t).norm() < kLeastBaseline) {
      map.refuse(at, fmt::format("cameras {} and {} stand at the same place: they measure no depth",
                                 i, rig.size() - 1));
    }
  }
  if (newest.lens.width != rig[0].lens.width || newest.lens.height != rig[0].lens.height) {
    map.refuse(at, fmt::format("camera {} has {}x{} pixels, camera 0 {}x{}", rig.size() - 1,
                               newest.lens.width, newest.lens.height, rig[0].lens.width,
                               rig[0].lens.height));
  }
}

}  // namespace

Camera read_camera(YamlMap map) {
  const Camera camera = take_camera(map);
  map.finish();
  return camera;
}

std::vector<MountedCamera> read_rig(YamlMap& map, const std::string& key) {
  std::vector<MountedCamera> rig;
  for (YamlMap& entry : map.maps(key)) {
    const Camera camera = take_camera(entry);
    rig.push_back(rig.empty() ? first_camera(entry, camera) : mounted_camera(entry, camera));
    entry.finish();
    refuse_rig(map, map.take(key)[rig.size() - 1], rig);
  }
  return rig;
}

// A model that is no pinhole has its own parameters before fx, fy, cx and cy.
Camera read_listed_camera(YamlMap& map) {
  const std::vector<int> size = map.counts("resolution");
  if (size.size() != 2) map.refuse(map.take("resolution"), "'resolution' must have 2 numbers");
  std::vector<double> intrinsics = map.list("intrinsics");
  if (intrinsics.size() < 4) map.refuse(map.take("intrinsics"), "'intrinsics' end in 4 numbers");
  const auto four = intrinsics.end() - 4;
  const Camera camera{size[0], size[1], four[0], four[1], four[2], four[3], PinholeLens{}};
  std::vector<double> lens(intrinsics.begin(), four);
  for (const char* key : {"distortion_coeffs", "distortion_coefficients"}) {
    std::ranges::copy(list_if_any(map, key), std::back_inserter(lens));
  }
  const std::string model = map.has("camera_model") ? map.text("camera_model") : "pinhole";
  if (model != "pinhole") return with_lens(map, "camera_model", camera, model, lens);
  return with_lens(map, "distortion_model", camera, map.text("distortion_model"), lens);
}

namespace {

bool is_slammot(YamlMap& map) { return map.has("model") || map.has("fx"); }
Camera read_own(YamlMap& map) { return read_camera(map); }

bool is_sequence(YamlMap& map) { return map.has("camera"); }
Camera read_of_sequence(YamlMap& map) { return read_camera(map.map("camera")); }

bool is_kalibr(YamlMap& map) { return map.has("cam0"); }
Camera read_kalibr(YamlMap& map) {
  YamlMap first = map.map("cam0");
  return read_listed_camera(first);
}

bool is_sensor(YamlMap& map) { return map.has("intrinsics"); }

// A matrix K and coefficients D as written by OpenCV and ROS, the latter as a file or as a message.
struct MatrixKeys {
  const char *width, *height, *K, *D;
};
constexpr MatrixKeys kMatrixKeys[] = {
    {"image_width", "image_height", "camera_matrix", "distortion_coefficients"},
    {"image_Width", "image_Height", "Camera_Matrix", "Distortion_Coefficients"},
    {"width", "height", "K", "D"},
    {"width", "height", "k", "d"}};

const MatrixKeys* matrix_keys(YamlMap& map) {
  const auto* keys =
      std::ranges::find_if(kMatrixKeys, [&](const MatrixKeys& k) { return map.has(k.K); });
  return keys == std::end(kMatrixKeys) ? nullptr : keys;
}

std::vector<double> matrix(YamlMap& map, const std::string& key) {
  return map.take(key).IsMap() ? map.map(key).list("data") : map.list(key);
}

// OpenCV writes no model: a flag tells its fisheye, the number of coefficients the others.
std::string lens_of_matrices(YamlMap& map, size_t coefficients) {
  if (map.has("distortion_model")) return map.text("distortion_model");
  if (map.has("fisheye_model") && map.real("fisheye_model") != 0.0) return "equidistant";
  return coefficients <= 5 ? "radtan" : "rational";
}

bool has_matrices(YamlMap& map) { return matrix_keys(map) != nullptr; }
Camera read_matrices(YamlMap& map) {
  const MatrixKeys& keys = *matrix_keys(map);
  const std::vector<double> K = matrix(map, keys.K);
  if (K.size() != 9 || K[3] != 0.0 || K[6] != 0.0 || K[7] != 0.0 || K[8] != 1.0) {
    map.refuse(map.take(keys.K), fmt::format("'{}' is no camera matrix of 9 numbers, row by row "
                                             "(fx, 0, cx, 0, fy, cy, 0, 0, 1)",
                                             keys.K));
  }
  if (K[1] != 0.0) map.refuse(map.take(keys.K), fmt::format("'{}' has a skew", keys.K));
  const Camera camera{map.positive_integer(keys.width),
                      map.positive_integer(keys.height),
                      K[0],
                      K[4],
                      K[2],
                      K[5],
                      PinholeLens{}};
  const std::vector<double> D = matrix(map, keys.D);
  const char* at = map.has("distortion_model") ? "distortion_model" : keys.D;
  return with_lens(map, at, camera, lens_of_matrices(map, D.size()), D);
}

// Version 1.0 of ORB-SLAM3's files numbers the cameras.
std::string orb_slam_prefix(YamlMap& map) { return map.has("Camera1.fx") ? "Camera1." : "Camera."; }
bool is_orb_slam(YamlMap& map) { return map.has(orb_slam_prefix(map) + "fx"); }
Camera read_orb_slam(YamlMap& map) {
  const std::string prefix = orb_slam_prefix(map);
  Camera camera;
  const bool has_size = map.has("Camera.width");
  camera.width = has_size ? map.positive_integer("Camera.width") : 0;
  camera.height = has_size ? map.positive_integer("Camera.height") : 0;
  camera.fx = map.positive(prefix + "fx");
  camera.fy = map.positive(prefix + "fy");
  camera.cx = map.real(prefix + "cx");
  camera.cy = map.real(prefix + "cy");
  const bool has_type = map.has("Camera.type");
  const std::string type = has_type ? map.text("Camera.type") : "PinHole";
  std::vector<std::string> names = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  if (type == "KannalaBrandt8") names = {"k1", "k2", "k3", "k4"};
  std::vector<double> distortion;
  for (const std::string& name : names) {
    distortion.push_back(map.has(prefix + name) ? map.real(prefix + name) : 0.0);
  }
  return with_lens(map, has_type ? "Camera.type" : prefix + "fx", camera, type, distortion);
}

struct Form {
  const char* name;
  bool (*recognises)(YamlMap& map);
  Camera (*read)(YamlMap& map);
};
constexpr Form kForms[] = {{"slammot", is_slammot, read_own},
                           {"a sequence", is_sequence, read_of_sequence},
                           {"kalibr", is_kalibr, read_kalibr},
                           {"EuRoC", is_sensor, read_listed_camera},
                           {"OpenCV or ROS", has_matrices, read_matrices},
                           {"ORB-SLAM", is_orb_slam, read_orb_slam}};

}  // namespace

CameraFile read_camera_file(const std::filesystem::path& file, const std::string& text) {
  YamlMap map = load_yaml(file, text);
  for (const Form& form : kForms) {
    if (!form.recognises(map)) continue;
    const Camera camera = form.read(map);
    const bool several = map.has("cam1") || map.has("Camera2.fx");
    return {camera, std::string(form.name) + (several ? ", the first of its cameras" : "")};
  }
  throw InputError(
      file, 1,
      "no calibration: expected model, width, height, fx, fy, cx, cy[, distortion], or "
      "a file of kalibr, EuRoC (sensor.yaml), OpenCV, ROS (camera_info) or ORB-SLAM");
}

}  // namespace slammot
