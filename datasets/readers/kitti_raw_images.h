// KITTI raw: a drive with `image_0N/timestamps.txt` and `image_0N/data/%010d.png` (the first of the
// four cameras that is there), its calibration `calib_cam_to_cam.txt` in the drive or in the folder
// of its day, and GPS/IMU in `oxts/`.
//
// The truth is the OXTS trajectory (see oxts.h) carried to the rectified camera by
// calib_imu_to_velo.txt and calib_velo_to_cam.txt; without these there is none. World = the first
// camera. Synced and rectified drives only.
#pragma once

#include "datasets/sequence/sequence.h"

namespace slammot {

bool is_kitti_raw(const std::filesystem::path& folder);
Sequence read_kitti_raw(const std::filesystem::path& folder);
void add_kitti_raw_pair(Sequence& sequence);  // as add_kitti_pair()

}  // namespace slammot
