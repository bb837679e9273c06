#include "datasets/readers/euroc_images.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "datasets/camera/camera_file.h"
#include "datasets/native/native_settings.h"
#include "datasets/readers/foreign_images.h"
#include "datasets/sequence/plausible.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

constexpr double kNanosecond = 1e-9;  // [s]
constexpr double kTogether = 1e-3;    // [s] between two images of one trigger

// The head of these files is a comment like any other.
bool next_data_row(TextTable& table, size_t columns) {
  while (table.next_comma_row(columns)) {
    if (!table.field(0).starts_with('#')) return true;
  }
  return false;
}

struct CameraSensor {
  Camera camera;
  Eigen::Isometry3d T_body_camera;
};

// Keys beside these (rate, comment, ...) are of no use here.
CameraSensor read_sensor(const Path& file) {
  YamlMap map = load_yaml(file, read_text_file(file));
  CameraSensor sensor{read_listed_camera(map), Eigen::Isometry3d::Identity()};
  const Eigen::Matrix<double, 16, 1> rows = map.map("T_BS").vector<16>("data");
  sensor.T_body_camera.matrix() =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(rows.data());
  if (!is_rotation(sensor.T_body_camera.linear())) {
    map.refuse(map.take("T_BS"), "'T_BS' is not a rotation and a translation");
  }
  return sensor;
}

std::vector<TimedPose> read_body_poses(const Path& file, const Eigen::Isometry3d& T_body_camera) {
  const std::string text = read_text_file(file);
  const std::string_view first = std::string_view(text).substr(0, text.find_first_of("\r\n"));
  const auto columns = static_cast<size_t>(1 + std::count(first.begin(), first.end(), ','));
  TextTable table(file, text);
  if (columns < 8) throw InputError(file, 1, "expected a time, a position and a quaternion");
  const Eigen::Quaterniond R_body_camera(T_body_camera.rotation());
  std::vector<TimedPose> poses;
  while (next_data_row(table, columns)) {
    const Eigen::Quaterniond wxyz(table.real(4), table.real(5), table.real(6), table.real(7));
    const Eigen::Quaterniond q = unit_quaternion(table, wxyz);
    const double time = table.real(0) * kNanosecond;
    table.refuse_if(poses.empty() ? time_fault(time) : order_fault(poses.back().timestamp, time));
    poses.push_back({time, vector_at(table, 1) + q * T_body_camera.translation(),
                     (q * R_body_camera).normalized()});
  }
  return poses;
}

void list_images(const Path& folder, const std::string& camera, Sequence& sequence) {
  const Path file = folder / camera / "data.csv";
  const std::string text = read_text_file(file);
  TextTable table(file, text);
  while (next_data_row(table, 2)) {
    add_image(table, table.real(0) * kNanosecond, camera + "/data/" + std::string(table.field(1)),
              sequence);
  }
  require_frames(file, sequence);
}

}  // namespace

bool is_euroc(const Path& folder) {
  return std::filesystem::is_regular_file(folder / "mav0" / "cam0" / "data.csv");
}

Sequence read_euroc(const Path& folder) {
  Sequence sequence = foreign_sequence(folder);
  const Path mav = folder / "mav0";
  list_images(folder, "mav0/cam0", sequence);
  const CameraSensor sensor = read_sensor(mav / "cam0" / "sensor.yaml");
  sequence.camera = sensor.camera;
  for (const char* name : {"state_groundtruth_estimate0", "mocap0"}) {
    const Path truth = mav / name / "data.csv";
    if (!is_there(truth)) continue;
    sequence.truth = true_cameras(read_body_poses(truth, sensor.T_body_camera), sequence.frames);
    break;
  }
  return sequence;
}

void add_euroc_pair(Sequence& sequence) {
  const Path mav = sequence.folder / "mav0";
  const Path list = mav / "cam1" / "data.csv", sensor = mav / "cam1" / "sensor.yaml";
  if (!is_there(list) || !is_there(sensor)) return;
  Sequence listed;
  list_images(sequence.folder, "mav0/cam1", listed);
  const CameraSensor other = read_sensor(sensor);
  const Eigen::Isometry3d T_C0_C =
      read_sensor(mav / "cam0" / "sensor.yaml").T_body_camera.inverse() * other.T_body_camera;
  const Eigen::Quaterniond R = Eigen::Quaterniond(T_C0_C.rotation()).normalized();
  add_camera(sensor, 0, {other.camera, R, T_C0_C.translation()},
             nearest_images(list, listed, sequence.frames, kTogether), sequence);
}

}  // namespace slammot
