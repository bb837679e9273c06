#include "datasets/readers/kitti_images.h"

#include <fmt/format.h>

#include "datasets/readers/foreign_images.h"
#include "datasets/sequence/plausible.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

std::optional<int> camera_number(const Path& folder) {
  for (int n = 0; n < 4; ++n) {
    if (std::filesystem::is_directory(folder / fmt::format("image_{}", n))) return n;
  }
  return std::nullopt;
}

std::vector<TimedPose> read_pose_rows(const Path& file, const Eigen::Vector3d& offset,
                                      const std::vector<Frame>& frames) {
  const std::string text = read_text_file(file);
  TextTable table(file, text);
  std::vector<TimedPose> poses;
  while (table.next_blank_row(12)) {
    if (poses.size() == frames.size()) table.refuse("more poses than times");
    Eigen::Matrix<double, 3, 4> T;
    for (int i = 0; i < 12; ++i) T(i / 4, i % 4) = table.bounded(static_cast<size_t>(i));
    const Eigen::Matrix3d R = T.leftCols<3>();
    if (!is_rotation(R)) table.refuse("not a rotation");
    poses.push_back({frames[poses.size()].timestamp, T.col(3) - R * offset,
                     Eigen::Quaterniond(R).normalized()});
  }
  if (poses.size() < frames.size()) table.refuse("fewer poses than times");
  return poses;
}

std::optional<Path> poses_file(const Sequence& sequence) {
  const Path published = std::filesystem::absolute(sequence.folder / "..").lexically_normal();
  for (const Path& file :
       {sequence.folder / "poses.txt", published / ".." / "poses" / (sequence.name + ".txt")}) {
    if (is_there(file)) return file;
  }
  return std::nullopt;
}

std::optional<CalibrationRow> calibration_row(const Path& file, std::string_view text,
                                              std::string_view key, size_t numbers) {
  TextTable table(file, text);
  while (table.next_blank_row()) {
    if (table.field(0) != std::string(key) + ":") continue;
    table.check_count(numbers + 1);
    CalibrationRow row{{}, table.line()};
    for (size_t i = 1; i <= numbers; ++i) row.numbers.push_back(table.bounded(i));
    return row;
  }
  return std::nullopt;
}

}  // namespace

RectifiedCamera rectified_camera(const Path& file, const std::string& key) {
  const auto [P, line] = required_calibration(file, key, 12);
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(P.data());
  const Camera camera{0, 0, P[0], P[5], P[2], P[6], PinholeLens{}};
  if (const Fault fault = camera_fault(camera)) throw InputError(file, line, key + ": " + *fault);
  if (!(std::abs(matrix.leftCols<3>().determinant()) > kSmallest)) {
    throw InputError(file, line, key + ": the matrix has no inverse");
  }
  return {camera, matrix.leftCols<3>().inverse() * matrix.col(3), line};
}

CalibrationRow required_calibration(const Path& file, const std::string& key, size_t numbers) {
  const auto row = calibration_row(file, read_text_file(file), key, numbers);
  if (!row) throw InputError(file, 0, fmt::format("no row '{}:'", key));
  return *row;
}

void add_pair(const Path& file, const std::string& key, int first, const std::string& images,
              int digits, Sequence& sequence) {
  if (first % 2 != 0 || !std::filesystem::is_directory(sequence.folder / images)) return;
  const std::string ending =
      image_ending(sequence.folder / images, std::string(static_cast<size_t>(digits), '0'));
  std::vector<std::string> names;
  for (const Frame& frame : sequence.frames) {
    names.push_back(fmt::format("{}/{:0{}}{}", images, frame.index, digits, ending));
  }
  const RectifiedCamera one = rectified_camera(file, key + std::to_string(first));
  const RectifiedCamera other = rectified_camera(file, key + std::to_string(first + 1));
  Camera camera = other.camera;
  camera.width = sequence.camera.width;
  camera.height = sequence.camera.height;
  add_camera(file, other.line, {camera, Eigen::Quaterniond::Identity(), one.offset - other.offset},
             std::move(names), sequence);
}

bool is_kitti(const Path& folder) {
  return std::filesystem::is_regular_file(folder / "calib.txt") &&
         std::filesystem::is_regular_file(folder / "times.txt") && camera_number(folder);
}

Sequence read_kitti(const Path& folder) {
  Sequence sequence = foreign_sequence(folder);
  const int camera = *camera_number(folder);
  const std::string images = fmt::format("image_{}", camera);
  const std::string ending = image_ending(folder / images, "000000");
  const Path times = folder / "times.txt";
  const std::string text = read_text_file(times);
  TextTable table(times, text);
  while (table.next_blank_row(1)) {
    add_image(table, table.real(0),
              fmt::format("{}/{:06}{}", images, sequence.frames.size(), ending), sequence);
  }
  require_frames(times, sequence);
  const Path calibration = folder / "calib.txt";
  const RectifiedCamera rectified = rectified_camera(calibration, fmt::format("P{}", camera));
  sequence.camera = rectified.camera;
  if (const auto poses = poses_file(sequence)) {
    sequence.truth =
        true_cameras(read_pose_rows(*poses, rectified.offset, sequence.frames), sequence.frames);
  }
  return sequence;
}

void add_kitti_pair(Sequence& sequence) {
  const int first = *camera_number(sequence.folder);
  add_pair(sequence.folder / "calib.txt", "P", first, fmt::format("image_{}", first + 1), 6,
           sequence);
}

}  // namespace slammot
