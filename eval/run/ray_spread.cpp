#include "eval/run/ray_spread.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace slammot {
namespace {

struct Seen {
  Bearing bearing;
  double relative_sigma;
};

// Empty where one has no ray.
std::vector<Seen> static_landmarks(const Camera& camera, const Frame& frame,
                                   const std::vector<LandmarkEstimate>& measured) {
  std::vector<Seen> result;
  for (const LandmarkEstimate& landmark : measured) {
    if (landmark.label != Label::kStatic || landmark.last_frame != frame.index) continue;
    const auto z =
        std::ranges::lower_bound(frame.observations, landmark.track, {}, &Observation::track);
    if (z == frame.observations.end() || z->track != landmark.track) continue;
    const auto bearing = camera.unproject(z->pixel);
    if (!bearing) return {};
    result.push_back({*bearing, z->relative_sigma});
  }
  return result;
}

}  // namespace

double ray_spread(const Camera& camera, double pixel_sigma, const Frame& frame,
                  const std::vector<LandmarkEstimate>& measured) {
  const std::vector<Seen> landmarks = static_landmarks(camera, frame, measured);
  if (landmarks.empty()) return kUndefined;
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (const auto& [b, _] : landmarks) {
    moments += b.ray * b.ray.transpose() / b.ray.squaredNorm();
  }
  // The eigenvector of the least eigenvalue is normal to the plane.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments);
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  double sum = 0.0;
  for (const auto& [b, relative_sigma] : landmarks) {
    const double distance =
        normal.dot(b.ray) / (b.J_ray_pixel.transpose() * normal).norm() / relative_sigma;  // [px]
    sum += distance * distance;
  }
  return std::sqrt(sum / static_cast<double>(landmarks.size())) / pixel_sigma;
}

}  // namespace slammot
