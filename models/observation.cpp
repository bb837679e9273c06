#include "slammot/models/observation.h"

namespace slammot {

std::optional<ObservedPixel> observe(const Camera& camera, const Eigen::Vector3d& r,
                                     const Eigen::Quaterniond& R, const Eigen::Vector3d& anchor,
                                     const Eigen::Vector3d& y) {
  const Eigen::Vector3d ray = ray_camera(r, R, anchor, y);
  const auto projection = camera.project(ray);
  if (!projection) return std::nullopt;
  const Matrix23d J_pixel_world = projection->J_pixel_ray * R.conjugate().toRotationMatrix();
  ObservedPixel z;
  z.pixel = projection->pixel;
  z.J_anchor = y.z() * J_pixel_world;
  z.J_pose.leftCols<3>() = -z.J_anchor;
  z.J_pose.rightCols<3>() = projection->J_pixel_ray * hat(ray);
  z.J_y = J_pixel_world * ray_jacobian(r, anchor, y);
  return z;
}

}  // namespace slammot
