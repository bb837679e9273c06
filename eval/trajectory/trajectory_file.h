// Trajectories as this and other programs write them, told apart by the columns of their first row:
//
//   TUM      t[s] tx ty tz qx qy qz qw
//   ov_eval  the same, and upper triangles of two 3x3 covariances, rotation (right) then position
//   KITTI    r11 r12 r13 tx r21 .. tz, one row for each frame: times are those of the frames
//   EuRoC    t[ns],tx,ty,tz,qw,qx,qy,qz with or without the nine columns of velocity and biases
//
// Each row is T_WC. A covariance that a file does not have is NaN; so is the one between position
// and rotation in an ov_eval file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/text/text_table.h"
#include "estimation/estimator.h"

namespace slammot {

// The one of a run folder. Throws InputError: no pose, a row that is none, times that do not
// increase.
std::vector<CameraEstimate> read_tum(const std::filesystem::path& file);

// Any of the above. A file without times must have a row for each of `frames`.
std::vector<CameraEstimate> read_trajectory(const std::filesystem::path& file,
                                            const std::vector<Frame>& frames);

// A symmetric matrix from its upper triangle by rows, from field `first` on; `nan` is let through.
template <int N>
Eigen::Matrix<double, N, N> symmetric_at(const TextTable& row, size_t first) {
  Eigen::Matrix<double, N, N> m;
  for (int i = 0; i < N; ++i) {
    for (int j = i; j < N; ++j) m(i, j) = m(j, i) = row.real_or_nan(first++);
  }
  return m;
}

}  // namespace slammot
