// The GPS/IMU unit of KITTI raw: latitude, longitude [deg], altitude [m], roll, pitch, yaw [rad] in
// `data/%010d.txt`, times in `timestamps.txt`.
//
// As the benchmark's devkit does: a Mercator projection with the scale of the first latitude,
//   x = s r lon, y = s r log tan(pi/4 + lat/2), z = alt, s = cos(lat_0), r = 6378137 m,
// and R = Rz(yaw) Ry(pitch) Rx(roll).
#pragma once

#include <Eigen/Geometry>

#include "datasets/sequence/true_poses.h"
#include "datasets/text/text_table.h"

namespace slammot {

struct TimedBody {
  double timestamp;               // [s]
  Eigen::Isometry3d T_world_imu;  // x east, y north, z up [m]
};

std::vector<TimedBody> read_oxts(const std::filesystem::path& folder);

// Poses of the camera, in the frame of the first of them.
std::vector<TimedPose> camera_poses(const std::vector<TimedBody>& bodies,
                                    const Eigen::Isometry3d& T_camera_imu);

// A row `2011-09-26 13:02:25.964389445` as seconds since 1970 (in UTC).
double date_seconds(const TextTable& row);

}  // namespace slammot
