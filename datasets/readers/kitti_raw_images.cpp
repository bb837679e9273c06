#include "datasets/readers/kitti_raw_images.h"

#include <fmt/format.h>

#include "datasets/readers/foreign_images.h"
#include "datasets/readers/kitti/oxts.h"
#include "datasets/readers/kitti_images.h"
#include "datasets/sequence/plausible.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

constexpr char kCameras[] = "calib_cam_to_cam.txt";

std::optional<int> raw_camera_number(const Path& folder) {
  for (int n = 0; n < 4; ++n) {
    if (std::filesystem::exists(folder / fmt::format("image_0{}", n) / "timestamps.txt")) return n;
  }
  return std::nullopt;
}

// In the drive itself, or in the folder of its day.
std::optional<Path> calibration_file(const Path& folder, const char* name) {
  for (const Path& file :
       {folder / name, std::filesystem::absolute(folder / "..").lexically_normal() / name}) {
    if (std::filesystem::exists(file)) return file;
  }
  return std::nullopt;
}

Eigen::Matrix3d rotation(const Path& file, const std::string& key) {
  const auto [rows, line] = required_calibration(file, key, 9);
  Eigen::Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
  if (!is_rotation(R)) throw InputError(file, line, key + ": not a rotation");
  return R;
}

int whole_pixels(const Path& file, int line, double size) {
  if (size >= 1.0 && size <= 1e5 && size == std::floor(size)) return static_cast<int>(size);
  throw InputError(file, line, fmt::format("{} px is no size of an image", size));
}

// `R:` and `T:` of a rigid calibration file.
Eigen::Isometry3d rigid(const Path& file) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotation(file, "R");
  T.translation() =
      Eigen::Map<const Eigen::Vector3d>(required_calibration(file, "T", 3).numbers.data());
  return T;
}

std::vector<std::optional<CameraState>> camera_truth(const Sequence& sequence, const Path& cameras,
                                                     const Eigen::Vector3d& offset) {
  const auto imu_to_velo = calibration_file(sequence.folder, "calib_imu_to_velo.txt");
  const auto velo_to_cam = calibration_file(sequence.folder, "calib_velo_to_cam.txt");
  const Path oxts = sequence.folder / "oxts";
  if (!imu_to_velo || !velo_to_cam || !std::filesystem::exists(oxts / "timestamps.txt")) return {};
  Eigen::Isometry3d rectify = Eigen::Isometry3d::Identity();
  rectify.linear() = rotation(cameras, "R_rect_00");
  rectify.translation() = offset;
  const Eigen::Isometry3d T_camera_imu = rectify * rigid(*velo_to_cam) * rigid(*imu_to_velo);
  return true_cameras(camera_poses(read_oxts(oxts), T_camera_imu), sequence.frames);
}

}  // namespace

bool is_kitti_raw(const Path& folder) {
  return raw_camera_number(folder).has_value() && calibration_file(folder, kCameras).has_value();
}

Sequence read_kitti_raw(const Path& folder) {
  Sequence sequence = foreign_sequence(folder);
  const int camera = *raw_camera_number(folder);
  const std::string images = fmt::format("image_0{}", camera);
  const std::string ending = image_ending(folder / images / "data", "0000000000");
  const Path times = folder / images / "timestamps.txt";
  const std::string text = read_text_file(times);
  TextTable table(times, text);
  while (table.next_blank_row(2)) {
    add_image(table, date_seconds(table),
              fmt::format("{}/data/{:010}{}", images, sequence.frames.size(), ending), sequence);
  }
  require_frames(times, sequence);
  const Path cameras = *calibration_file(folder, kCameras);
  const std::string key = fmt::format("P_rect_0{}", camera);
  const RectifiedCamera rectified = rectified_camera(cameras, key);
  sequence.camera = rectified.camera;
  const auto [size, line] = required_calibration(cameras, fmt::format("S_rect_0{}", camera), 2);
  sequence.camera.width = whole_pixels(cameras, line, size[0]);
  sequence.camera.height = whole_pixels(cameras, line, size[1]);
  if (const Fault fault = camera_fault(sequence.camera)) {
    throw InputError(cameras, rectified.line, fmt::format("{}: {}", key, *fault));
  }
  sequence.truth = camera_truth(sequence, cameras, rectified.offset);
  return sequence;
}

void add_kitti_raw_pair(Sequence& sequence) {
  const int first = *raw_camera_number(sequence.folder);
  add_pair(*calibration_file(sequence.folder, kCameras), "P_rect_0", first,
           fmt::format("image_0{}/data", first + 1), 10, sequence);
}

}  // namespace slammot
