// Relative errors over distances along the true path, as KITTI's benchmark has them (Geiger et al.
// 2012), and how the scale of an estimate drifts along it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "eval/metrics/pose_pairs.h"

namespace slammot {

// Means over all stretches; NaN where the path is shorter than each of the lengths.
struct DistanceErrors {
  int stretches = 0;
  double translation_percent = 0.0;  // of the length
  double scaled_percent = 0.0;       // the same, the estimate's displacements times `scale`
  double rotation_deg_per_m = 0.0;
};

// Over stretches of each of `lengths` [m], from every `step`-th pose on.
DistanceErrors distance_errors(const std::vector<PosePair>& pairs, std::span<const double> lengths,
                               int step, double scale);

inline constexpr std::array<double, 8> kKittiLengths{100, 200, 300, 400, 500, 600, 700, 800};
inline constexpr int kKittiStep = 10;

double true_path_length(const std::vector<PosePair>& pairs);  // [m]

inline constexpr std::size_t kTenths = 10;

// Size of the estimate over that of the truth, by tenths of the true path: of the positions' RMS
// distances from their mean. NaN where the true camera stays within a millimetre.
std::array<double, kTenths> scale_along_path(const std::vector<PosePair>& pairs);

}  // namespace slammot
