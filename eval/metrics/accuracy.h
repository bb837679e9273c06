// How far an estimated trajectory is from the true one: without alignment (when the scale and the
// first pose are known), after alignment (ATE), and over one second (RPE).
//
// Position error |r_true - r_est| [m]; rotation error |Log(R_est' R_true)| [deg]. RPE after Sturm
// et al. 2012: E = (T_i^-1 T_j)^-1 (T^_i^-1 T^_j), j the first frame at least `interval` after i.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "eval/metrics/alignment.h"
#include "eval/metrics/path_errors.h"
#include "eval/metrics/pose_pairs.h"

namespace slammot {

struct Accuracy {
  int poses = 0;
  double position_rmse = 0.0;   // [m]
  double position_max = 0.0;    // [m]
  double position_final = 0.0;  // [m]
  double rotation_rmse_deg = 0.0;
  double rotation_max_deg = 0.0;
  double ate_se3 = 0.0;     // [m], RMSE after SE(3) alignment
  double ate_sim3 = 0.0;    // [m], RMSE after Sim(3) alignment
  double scale = 1.0;       // of the Sim(3) alignment: true size over estimated size
  std::string sim3_reason;  // why the last two are not defined; empty where they are
  int relative_pairs = 0;
  double relative_position_rmse = 0.0;  // [m] over one second
  double relative_scaled_rmse = 0.0;    // [m], the estimate's displacements times `scale`
  double relative_rotation_rmse_deg = 0.0;
  DistanceErrors over_tenths;  // of a tenth of the path, from every pose on
  DistanceErrors over_kitti;   // of KITTI's 100 to 800 m
  std::array<double, kTenths> scale_along_path{};

  void forget_rotations();  // and the displacements, which are seen from them: not defined
};

// The first frame of a failed estimate, if there is one: its position error is above a tenth of the
// path so far, and above a metre or a tenth of the whole path, whichever is less.
// `after_alignment`, where the sequence fixes no scale: above a tenth of the whole path after the
// similarity alignment, or above a third of the farthest that the camera gets from where it began,
// as an alignment makes a point of an estimate that follows no part of a path in a small room.
// Of a camera that stays within a millimetre, a metre is taken for all. Less than kLeastFailure is
// none, however short the path.
inline constexpr double kLeastFailure = 0.1;  // [m]
std::optional<int> failed_at(const std::vector<PosePair>& pairs, bool after_alignment);

// The same in words: what the error of a failed run exceeds.
std::string failure_bound(bool after_alignment);

// The Sim(3) alignment of the estimated positions to the true ones; SE(3) where one of the two does
// not move.
Similarity similarity(const std::vector<PosePair>& pairs);

// The estimates moved by it; their orientations and covariances as they were.
std::vector<PosePair> aligned(std::vector<PosePair> pairs);

Accuracy accuracy(const std::vector<PosePair>& pairs, double relative_interval = 1.0);

double position_error(const PosePair& pair);      // [m]
double rotation_error_deg(const PosePair& pair);  // [deg]

}  // namespace slammot
