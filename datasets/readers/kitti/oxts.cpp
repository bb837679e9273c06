#include "datasets/readers/kitti/oxts.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <numbers>

#include "datasets/sequence/sequence.h"

namespace slammot {
namespace {

using Path = std::filesystem::path;

constexpr double kEarthRadius = 6378137.0;  // [m]
constexpr size_t kFields = 30;

struct Reading {
  double latitude, longitude;  // [rad]
  double altitude;             // [m]
  Eigen::Quaterniond orientation;
};

Reading read_reading(const Path& file) {
  const std::string text = read_text_file(file);
  TextTable table(file, text);
  if (!table.next_blank_row(kFields)) table.refuse("is empty");
  constexpr double kDegree = std::numbers::pi / 180.0;
  const auto about = [&](size_t field, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(table.bounded(field), axis);
  };
  if (!(std::abs(table.real(0)) < 90.0)) table.refuse("the latitude is not below 90 degrees");
  if (!(std::abs(table.real(1)) <= 360.0)) table.refuse("the longitude is more than a turn");
  return {table.real(0) * kDegree, table.real(1) * kDegree, table.bounded(2),
          about(5, Eigen::Vector3d::UnitZ()) * about(4, Eigen::Vector3d::UnitY()) *
              about(3, Eigen::Vector3d::UnitX())};
}

Eigen::Isometry3d mercator(const Reading& reading, double scale) {
  const double r = scale * kEarthRadius;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = reading.orientation.toRotationMatrix();
  T.translation() << r * reading.longitude,
      r * std::log(std::tan(std::numbers::pi / 4.0 + reading.latitude / 2.0)), reading.altitude;
  return T;
}

}  // namespace

double date_seconds(const TextTable& row) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, used = 0;
  double second = 0.0;
  const std::string text = fmt::format("{} {}", row.field(0), row.field(1));
  const int read = std::sscanf(text.c_str(), "%d-%d-%d %d:%d:%lf%n", &year, &month, &day, &hour,
                               &minute, &second, &used);
  const std::chrono::year_month_day date{std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  const bool in_a_day = hour >= 0 && hour < 24 && minute >= 0 && minute < 60 && second >= 0.0 &&
                        second < 61.0 && year >= 1970 && year < 10000;
  if (read != 6 || !in_a_day || static_cast<size_t>(used) != text.size() || !date.ok()) {
    row.refuse(fmt::format("'{}' is not a date and a time", text));
  }
  const auto days = static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
  return days * 86400.0 + hour * 3600.0 + minute * 60.0 + second;
}

std::vector<TimedBody> read_oxts(const Path& folder) {
  const Path times = folder / "timestamps.txt";
  const std::string text = read_text_file(times);
  TextTable table(times, text);
  std::vector<TimedBody> bodies;
  double scale = 0.0;
  while (table.next_blank_row(2)) {
    const double timestamp = date_seconds(table);
    const Path file = folder / "data" / fmt::format("{:010}.txt", table.line() - 1);
    const Reading reading = read_reading(file);
    if (bodies.empty()) scale = std::cos(reading.latitude);
    if (!bodies.empty() && !(timestamp > bodies.back().timestamp)) continue;  // some stand still
    bodies.push_back({timestamp, mercator(reading, scale)});
  }
  return bodies;
}

std::vector<TimedPose> camera_poses(const std::vector<TimedBody>& bodies,
                                    const Eigen::Isometry3d& T_camera_imu) {
  std::vector<TimedPose> poses;
  if (bodies.empty()) return poses;
  const Eigen::Isometry3d T_imu_camera = T_camera_imu.inverse();
  const Eigen::Isometry3d T_first_world = (bodies.front().T_world_imu * T_imu_camera).inverse();
  for (const TimedBody& body : bodies) {
    const Eigen::Isometry3d T = T_first_world * body.T_world_imu * T_imu_camera;
    poses.push_back({body.timestamp, T.translation(), Eigen::Quaterniond(T.rotation())});
  }
  return poses;
}

}  // namespace slammot
