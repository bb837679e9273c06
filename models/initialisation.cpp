#include "models/initialisation.h"

namespace slammot {

std::optional<NewLandmark> initialise(const Camera& camera, const Eigen::Quaterniond& R,
                                      const Eigen::Vector2d& pixel, double inverse_depth) {
  const auto bearing = camera.unproject(pixel);
  if (!bearing) return std::nullopt;
  const Eigen::Vector3d g = R * bearing->ray;
  constexpr double kVertical = 1e-12;  // squared sine of the angle to the y axis
  if (g.x() * g.x() + g.z() * g.z() < kVertical * g.squaredNorm()) return std::nullopt;
  const Matrix23d J_angles_ray = angles_jacobian(g) * R.toRotationMatrix();
  NewLandmark landmark;
  landmark.y << angles(g, 0.0), inverse_depth;
  landmark.J_angles_rotation = -J_angles_ray * hat(bearing->ray);
  landmark.J_angles_pixel = J_angles_ray * bearing->J_ray_pixel;
  return landmark;
}

NewKnownLandmark initialise_known(const KnownLandmark& known, const Eigen::Vector3d& anchor) {
  const Eigen::Vector3d d = known.position - anchor;
  return {inverse_depth_of(d), inverse_depth_jacobian(d)};
}

}  // namespace slammot
