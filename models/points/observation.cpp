#include "models/points/observation.h"

namespace slammot {

namespace {

constexpr double kNearest = 0.01;  // [m]
constexpr double kGrazing = 0.05;  // cosine to the optical axis: 87 degrees

}  // namespace

bool is_grazing(const Eigen::Vector3d& ray_camera) {
  return ray_camera.z() < kGrazing * ray_camera.norm();
}

std::optional<ObservedPixel> observe(const MountedCamera& camera, const PointFunctions& point,
                                     const Eigen::Vector3d& r, const Eigen::Quaterniond& R,
                                     const Eigen::Vector3d& anchor, const Eigen::Vector3d& y) {
  const PointRay from_anchor = point.ray(y);
  const double rho = from_anchor.inverse_depth;
  const Eigen::Vector3d ray_first = ray_camera(r, R, anchor, from_anchor.direction, rho);
  const Eigen::Vector3d ray = camera.ray(ray_first, rho);
  if (ray.norm() < kNearest * rho || is_grazing(ray)) return std::nullopt;
  const auto projection = camera.lens.project(ray);
  if (!projection) return std::nullopt;
  Matrix23d J_ray = projection->J_pixel_ray;  // of the ray of camera 0
  if (!camera.is_first) J_ray *= camera.R.conjugate().toRotationMatrix();
  ObservedPixel z;
  z.J_world = J_ray * R.conjugate().toRotationMatrix();
  z.pixel = projection->pixel;
  z.J_anchor = rho * z.J_world;
  z.J_pose.leftCols<3>() = -z.J_anchor;
  z.J_pose.rightCols<3>() = J_ray * hat(ray_first);
  const Eigen::Matrix3d J_ray_y =
      from_anchor.J_direction + (anchor - r) * from_anchor.J_inverse_depth;
  z.J_y = z.J_world * J_ray_y;
  if (!camera.is_first) z.J_y -= J_ray * camera.t * from_anchor.J_inverse_depth;
  return z;
}

std::optional<ObservedPixel> expect(const MountedCamera& camera, const PointFunctions& point,
                                    const Eigen::Vector3d& r, const Eigen::Quaterniond& R,
                                    const Eigen::Vector3d& anchor, const Eigen::Vector3d& y) {
  auto z = observe(camera, point, r, R, anchor, y);
  if (!z) return z;
  const Eigen::Array2d size(camera.lens.width, camera.lens.height);
  const Eigen::Array2d from_centre = z->pixel.array() - 0.5 * size;
  if (!(from_centre.abs() < 1.5 * size).all()) return std::nullopt;
  return z;
}

bool in_view(const Camera& camera, const PointFunctions& point, const Eigen::Vector3d& r,
             const Eigen::Quaterniond& R, const Eigen::Vector3d& anchor, const Eigen::Vector3d& y) {
  const PointRay from_anchor = point.ray(y);
  const Eigen::Vector3d ray =
      ray_camera(r, R, anchor, from_anchor.direction, from_anchor.inverse_depth);
  if (is_grazing(ray)) return false;
  const auto projection = camera.project(ray);
  return projection && camera.in_image(projection->pixel);
}

}  // namespace slammot
