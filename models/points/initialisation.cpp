#include "models/points/initialisation.h"

#include "models/points/observation.h"

namespace slammot {

std::optional<NewLandmark> initialise(const Camera& camera, const PointFunctions& point,
                                      const Eigen::Quaterniond& R, const Eigen::Vector2d& pixel,
                                      double inverse_depth) {
  const auto bearing = camera.unproject(pixel);
  if (!bearing || is_grazing(bearing->ray)) return std::nullopt;
  const Eigen::Vector3d g = R * bearing->ray;
  if (!point.exists(g, inverse_depth)) return std::nullopt;
  const Matrix34d J_y = point.of_jacobian(g, inverse_depth);
  const Eigen::Matrix3d J_y_ray = J_y.leftCols<3>() * R.toRotationMatrix();
  NewLandmark landmark;
  landmark.y = point.of(g, inverse_depth, Eigen::Vector3d::Zero());
  landmark.J_rotation = -J_y_ray * hat(bearing->ray);
  landmark.J_pixel = J_y_ray * bearing->J_ray_pixel;
  landmark.J_inverse_depth = J_y.col(3);
  return landmark;
}

NewKnownLandmark initialise_known(const PointFunctions& point, const KnownLandmark& known,
                                  const Eigen::Vector3d& anchor) {
  const Eigen::Vector3d d = known.position - anchor;
  return {point_at(point, d), point_at_jacobian(point, d)};
}

}  // namespace slammot
