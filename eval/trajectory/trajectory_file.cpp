#include "eval/trajectory/trajectory_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "datasets/sequence/plausible.h"
#include "datasets/text/input_error.h"
#include "datasets/text/number.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

struct Format {
  std::string_view name;
  bool commas;
  size_t columns;
  bool timed;
  CameraEstimate (*pose)(const TextTable& row);
};

CameraEstimate unknown_covariance() {
  CameraEstimate camera;
  camera.covariance.setConstant(kUndefined);
  return camera;
}

// w, x, y, z stand in these fields.
Eigen::Quaterniond quaternion_at(const TextTable& row, const std::array<size_t, 4>& fields) {
  const auto [w, x, y, z] = fields;
  Eigen::Quaterniond q(row.real(w), row.real(x), row.real(y), row.real(z));
  row.refuse_if(quaternion_fault(q));
  return q.normalized();
}

CameraEstimate tum_pose(const TextTable& row) {
  CameraEstimate camera = unknown_covariance();
  camera.timestamp = row.real(0);
  camera.state.position = vector_at(row, 1);
  camera.state.orientation = quaternion_at(row, {7, 4, 5, 6});
  return camera;
}

void refuse_undefined(const TextTable& row, size_t first) {
  for (size_t i = first; i < row.fields(); ++i) row.real(i);
}

CameraEstimate ov_eval_pose(const TextTable& row) {
  CameraEstimate camera = tum_pose(row);
  refuse_undefined(row, 8);
  camera.covariance.block<3, 3>(kRotation, kRotation) = symmetric_at<3>(row, 8);
  camera.covariance.block<3, 3>(kPosition, kPosition) = symmetric_at<3>(row, 14);
  return camera;
}

CameraEstimate kitti_pose(const TextTable& row) {
  Eigen::Matrix3d R;
  CameraEstimate camera = unknown_covariance();
  for (int i = 0; i < 3; ++i) {
    const auto first = 4 * static_cast<std::size_t>(i);
    R.row(i) = vector_at(row, first).transpose();
    camera.state.position(i) = row.bounded(first + 3);
  }
  const bool rotates = (R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < 1e-2;
  if (!rotates || R.determinant() < 0.0) row.refuse("the 3x3 part is not a rotation");
  camera.state.orientation = Eigen::Quaterniond(R).normalized();
  return camera;
}

CameraEstimate euroc_pose(const TextTable& row) {
  CameraEstimate camera = unknown_covariance();
  const auto nanoseconds = parse_number<std::int64_t>(row.field(0));
  if (!nanoseconds) {
    row.refuse(
        fmt::format("'{}' is not a time in nanoseconds, as EuRoC's rows between commas have; "
                    "rows of TUM have blanks between their fields",
                    row.field(0)));
  }
  camera.timestamp = 1e-9 * static_cast<double>(*nanoseconds);
  camera.state.position = vector_at(row, 1);
  camera.state.orientation = quaternion_at(row, {4, 5, 6, 7});
  return camera;
}

constexpr Format kTum{"TUM", false, 8, true, tum_pose};
constexpr Format kFormats[] = {kTum,
                               {"KITTI", false, 12, false, kitti_pose},
                               {"ov_eval", false, 20, true, ov_eval_pose},
                               {"EuRoC", true, 8, true, euroc_pose},
                               {"EuRoC", true, 17, true, euroc_pose}};

// Fields of the first row that is no comment.
const Format& format_of(const Path& file, const std::string& text) {
  TextTable table(file, text);
  if (!table.next_blank_row()) throw InputError(file, 0, "holds no pose");
  std::string row;
  for (size_t i = 0; i < table.fields(); ++i) row += std::string(table.field(i)) + ' ';
  const auto commas = static_cast<size_t>(std::ranges::count(row, ','));
  const size_t columns = commas > 0 ? commas + 1 : table.fields();
  for (const Format& format : kFormats) {
    if (format.commas == (commas > 0) && format.columns == columns) return format;
  }
  table.refuse(
      fmt::format("{} columns{}: a trajectory has 8 (TUM), 12 (KITTI) or 20 (ov_eval) between "
                  "blanks, or 8 or 17 (EuRoC) between commas",
                  columns, commas > 0 ? " between commas" : ""));
}

bool next_row(TextTable& table, const Format& format) {
  if (!format.commas) return table.next_blank_row(format.columns);
  table.pass_comments();
  return table.next_comma_row(format.columns);
}

std::vector<CameraEstimate> read_rows(const Path& file, const std::string& text,
                                      const Format& format) {
  std::vector<CameraEstimate> cameras;
  for (TextTable row(file, text); next_row(row, format);) {
    const CameraEstimate camera = format.pose(row);
    if (format.timed) {
      row.refuse_if(time_fault(camera.timestamp));
      if (!cameras.empty()) {
        row.refuse_if(order_fault(cameras.back().timestamp, camera.timestamp));
      }
    }
    cameras.push_back(camera);
  }
  if (cameras.empty()) throw InputError(file, 0, "holds no pose");
  return cameras;
}

}  // namespace

std::vector<CameraEstimate> read_tum(const Path& file) {
  return read_rows(file, read_text_file(file), kTum);
}

std::vector<CameraEstimate> read_trajectory(const Path& file, const std::vector<Frame>& frames) {
  const std::string text = read_text_file(file);
  const Format& format = format_of(file, text);
  std::vector<CameraEstimate> cameras = read_rows(file, text, format);
  if (format.timed) return cameras;
  if (cameras.size() != frames.size()) {
    throw InputError(file, 0,
                     fmt::format("{} rows without times, but the sequence has {} frames",
                                 cameras.size(), frames.size()));
  }
  for (size_t i = 0; i < cameras.size(); ++i) cameras[i].timestamp = frames[i].timestamp;
  return cameras;
}

}  // namespace slammot
