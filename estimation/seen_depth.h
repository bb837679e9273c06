// How far a static landmark is, as seen from its anchor.
#pragma once

#include <cmath>

#include "models/points/point_functions.h"

namespace slammot {

// Of a static landmark measured in the frame in hand, at its birth, as it is believed now.
struct SeenDepth {
  double inverse_depth = 0.0;  // [1/m]
  double sigma = 0.0;          // [1/m]
};

// To first order, at y with its covariance.
inline SeenDepth seen_depth(const PointFunctions& point, const Eigen::Vector3d& y,
                            const Eigen::Matrix3d& covariance) {
  const Eigen::RowVector3d J = point.inverse_depth_jacobian(y);
  return {point.inverse_depth(y), std::sqrt((J * covariance).dot(J))};
}

}  // namespace slammot
