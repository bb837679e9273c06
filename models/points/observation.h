// Observation of a landmark (thesis 2.1.2, after Montiel et al. 2006): the pixel of the ray
// R' (rho (a - r) + G), regular at rho = 0, and of another camera of a rig what rig.h makes of it.
// All landmark models and parametrisations share it.
#pragma once

#include "models/points/point_functions.h"
#include "models/rig.h"

namespace slammot {

template <typename T>
Vector3<T> ray_camera(const Vector3<T>& r, const Eigen::Quaternion<T>& R, const Vector3<T>& anchor,
                      const Vector3<T>& direction, const T& inverse_depth) {
  return R.conjugate() * Vector3<T>(inverse_depth * (anchor - r) + direction);
}

struct ObservedPixel {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 6> J_pose;  // with respect to [dr (W), dtheta (C0, right)]
  Matrix23d J_anchor;
  Matrix23d J_y;
  Matrix23d J_world;  // with respect to the ray in W
};

// Whether a ray is within 3 degrees of the camera's plane, or behind it. There h has a pole: what a
// Jacobian of 10^9 px m is eliminated from loses all its digits. Pixels that far out, which a
// fisheye may have in its corners, make no landmark and are not used.
bool is_grazing(const Eigen::Vector3d& ray_camera);

// Nothing when the landmark is_grazing(), or within a centimetre of the camera: there every pixel
// costs nothing, and a smoother would be drawn into that pole.
std::optional<ObservedPixel> observe(const MountedCamera& camera, const PointFunctions& point,
                                     const Eigen::Vector3d& r, const Eigen::Quaterniond& R,
                                     const Eigen::Vector3d& anchor, const Eigen::Vector3d& y);

// The same for a landmark that has been measured: nothing either when the prediction lies further
// outside the image than the image is large. There h is so curved (it has a pole at the camera's
// plane) that its linearisation makes S meaningless: a measurement 10^5 pixels away passes the
// gate.
std::optional<ObservedPixel> expect(const MountedCamera& camera, const PointFunctions& point,
                                    const Eigen::Vector3d& r, const Eigen::Quaterniond& R,
                                    const Eigen::Vector3d& anchor, const Eigen::Vector3d& y);

// Whether a landmark is predicted to be in the image.
bool in_view(const Camera& camera, const PointFunctions& point, const Eigen::Vector3d& r,
             const Eigen::Quaterniond& R, const Eigen::Vector3d& anchor, const Eigen::Vector3d& y);

}  // namespace slammot
