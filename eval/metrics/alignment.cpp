#include "eval/metrics/alignment.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace slammot {
namespace {

Eigen::Matrix3Xd as_columns(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Matrix3Xd columns(3, static_cast<Eigen::Index>(points.size()));
  for (size_t i = 0; i < points.size(); ++i) columns.col(static_cast<Eigen::Index>(i)) = points[i];
  return columns;
}

}  // namespace

Similarity align(const std::vector<Eigen::Vector3d>& estimate,
                 const std::vector<Eigen::Vector3d>& truth, AlignmentGroup group) {
  Similarity similarity;
  if (estimate.empty()) return similarity;
  const Eigen::Matrix3Xd from = as_columns(estimate);
  const Eigen::Matrix3Xd to = as_columns(truth);
  const bool moves = (from.colwise() - from.rowwise().mean()).squaredNorm() > 0.0;
  if (estimate.size() < 3 || !moves) {  // neither rotation nor scale can be seen
    similarity.translation = to.rowwise().mean() - from.rowwise().mean();
    return similarity;
  }
  const Eigen::Matrix4d T = Eigen::umeyama(from, to, group == AlignmentGroup::kSim3);
  similarity.scale = T.topLeftCorner<3, 3>().col(0).norm();
  if (similarity.scale > 0.0) similarity.rotation = T.topLeftCorner<3, 3>() / similarity.scale;
  similarity.translation = T.topRightCorner<3, 1>();
  return similarity;
}

double absolute_trajectory_error(const std::vector<Eigen::Vector3d>& estimate,
                                 const std::vector<Eigen::Vector3d>& truth,
                                 const Similarity& alignment) {
  if (estimate.empty()) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (size_t i = 0; i < estimate.size(); ++i) {
    sum += (truth[i] - alignment * estimate[i]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(estimate.size()));
}

}  // namespace slammot
