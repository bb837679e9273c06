// Trajectory alignment (Umeyama 1991): the similarity S with truth ~ scale R estimate + t that
// minimises the squared distances, with the scale free (Sim(3)) or one (SE(3)).
//
// Nothing here touches a covariance: what an alignment leaves of NEES is another matter
// (trajectory/align_run.h).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slammot {

struct Similarity {
  double scale = 1.0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return scale * (rotation * point) + translation;
  }
};

enum class AlignmentGroup { kSE3, kSim3 };

// Both lists are of equal length. Of fewer than three points only the translation is found.
Similarity align(const std::vector<Eigen::Vector3d>& estimate,
                 const std::vector<Eigen::Vector3d>& truth, AlignmentGroup group);

// RMSE of the positions after alignment [m].
double absolute_trajectory_error(const std::vector<Eigen::Vector3d>& estimate,
                                 const std::vector<Eigen::Vector3d>& truth,
                                 const Similarity& alignment);

}  // namespace slammot
