#include "eval/run/ray_spread.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace slammot {

double ray_spread(const Sequence& sequence, const Frame& frame,
                  const std::vector<LandmarkEstimate>& measured) {
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  int rays = 0;
  for (const LandmarkEstimate& landmark : measured) {
    if (landmark.label != Label::kStatic || landmark.last_frame != frame.index) continue;
    const auto z =
        std::ranges::lower_bound(frame.observations, landmark.track, {}, &Observation::track);
    if (z == frame.observations.end() || z->track != landmark.track) continue;
    const auto bearing = sequence.camera.unproject(z->pixel);
    if (!bearing) return kUndefined;
    const Eigen::Vector3d ray = bearing->ray.normalized();
    moments += ray * ray.transpose();
    ++rays;
  }
  if (rays == 0) return kUndefined;
  // The least eigenvalue is that of the normal of the plane: the sum of squared sines to it.
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvalues()(0);
  const double angle = std::sqrt(std::max(least, 0.0) / rays);
  return angle * sequence.camera.fx / sequence.pixel_sigma;
}

}  // namespace slammot
