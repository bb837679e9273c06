#include "eval/run/ray_spread.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace slammot {
namespace {

// Empty where one has no ray.
std::vector<Bearing> static_bearings(const Camera& camera, const Frame& frame,
                                     const std::vector<LandmarkEstimate>& measured) {
  std::vector<Bearing> bearings;
  for (const LandmarkEstimate& landmark : measured) {
    if (landmark.label != Label::kStatic || landmark.last_frame != frame.index) continue;
    const auto z =
        std::ranges::lower_bound(frame.observations, landmark.track, {}, &Observation::track);
    if (z == frame.observations.end() || z->track != landmark.track) continue;
    const auto bearing = camera.unproject(z->pixel);
    if (!bearing) return {};
    bearings.push_back(*bearing);
  }
  return bearings;
}

}  // namespace

double ray_spread(const Camera& camera, double pixel_sigma, const Frame& frame,
                  const std::vector<LandmarkEstimate>& measured) {
  const std::vector<Bearing> bearings = static_bearings(camera, frame, measured);
  if (bearings.empty()) return kUndefined;
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (const Bearing& b : bearings) moments += b.ray * b.ray.transpose() / b.ray.squaredNorm();
  // The eigenvector of the least eigenvalue is normal to the plane.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments);
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  double sum = 0.0;
  for (const Bearing& b : bearings) {
    const double distance =
        normal.dot(b.ray) / (b.J_ray_pixel.transpose() * normal).norm();  // [px]
    sum += distance * distance;
  }
  return std::sqrt(sum / static_cast<double>(bearings.size())) / pixel_sigma;
}

}  // namespace slammot
