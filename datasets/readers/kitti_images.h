// KITTI odometry: `calib.txt` (rows `P0: ` and 12 numbers), `times.txt`, `image_N/%06d.png` (the
// first camera that has a folder), and the poses as `poses.txt` beside them or, as published, in
// `../../poses/SEQUENCE.txt`.
//
// Rectified pinholes, z forward, y down. The poses are T_world_camera of camera 0, rows of 3x4
// matrices; camera N stands at K^-1 P_N(:,4) before it, which is carried along. Of motion and
// depths nothing is stated.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "datasets/sequence/sequence.h"

namespace slammot {

bool is_kitti(const std::filesystem::path& folder);
Sequence read_kitti(const std::filesystem::path& folder);
void add_kitti_pair(Sequence& sequence);  // image_1 beside image_0, image_3 beside image_2

// A row of a KITTI calibration file, `KEY: numbers`.
struct CalibrationRow {
  std::vector<double> numbers;
  int line = 0;
};

// Throws InputError if the key is not there.
CalibrationRow required_calibration(const std::filesystem::path& file, const std::string& key,
                                    size_t numbers);

// A rectified camera from its 3x4 projection matrix, the row `key` of a calibration file, and its
// place t in x_N = x_0 + t.
struct RectifiedCamera {
  Camera camera;           // width and height 0: not known here
  Eigen::Vector3d offset;  // t [m]
  int line = 0;            // of the row
};
RectifiedCamera rectified_camera(const std::filesystem::path& file, const std::string& key);

// Appends camera `first` + 1 of a calibration's rows `key`N beside camera `first`, which is camera
// 0, where `first` is even (the grey pair is 0 and 1, that of colour 2 and 3) and the folder
// `images` is there. Its images are frame numbers of so many digits.
void add_pair(const std::filesystem::path& file, const std::string& key, int first,
              const std::string& images, int digits, Sequence& sequence);

}  // namespace slammot
