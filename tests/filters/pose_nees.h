// The mean NEES of the pose (6) over the frames of a simulated sequence.
#pragma once

#include <Eigen/Cholesky>

#include "datasets/sequence/sequence.h"
#include "estimation/estimator.h"

namespace slammot {

inline double mean_pose_nees(Estimator& estimator, const Sequence& sequence) {
  NoStages stages;
  double sum = 0.0;
  for (const Frame& frame : sequence.frames) {
    estimator.process(frame, stages);
    const CameraEstimate x = estimator.camera();
    const Vector12d e = boxminus(*sequence.truth[static_cast<std::size_t>(frame.index)], x.state);
    const Eigen::Matrix<double, 6, 6> P = x.covariance.topLeftCorner<6, 6>();
    sum += e.head<6>().dot(P.ldlt().solve(e.head<6>()));
  }
  return sum / static_cast<double>(sequence.frames.size());
}

}  // namespace slammot
