// Undelayed initialisation (thesis 2.1.3, eq. 2.7): a landmark enters the state at its first pixel.
//
// Its anchor is the camera's position, its direction the pixel's, its inverse depth and motion the
// prior's. The estimator adds the covariance J diag(P, R, sigma_rho^2, sigma_w^2) J' with these
// Jacobians; a smoother states the same as a bearing factor and priors. The prior is one of rho
// whatever y is, so that all parametrisations are told the same.
#pragma once

#include "models/camera.h"
#include "models/measurement.h"
#include "models/points/point_functions.h"

namespace slammot {

struct NewLandmark {
  Eigen::Vector3d y;
  Eigen::Matrix3d J_rotation;  // dy / dtheta_camera
  Matrix32d J_pixel;
  Eigen::Vector3d J_inverse_depth;
};

// Nothing when the lens has no ray for the pixel, or a grazing one (observation.h), or the
// parametrisation no y for the ray.
std::optional<NewLandmark> initialise(const Camera& camera, const PointFunctions& point,
                                      const Eigen::Quaterniond& R, const Eigen::Vector2d& pixel,
                                      double inverse_depth);

// A landmark known beforehand, seen from an anchor: y and d y / d(position in W) (= -d y / d
// anchor).
struct NewKnownLandmark {
  Eigen::Vector3d y;
  Eigen::Matrix3d J_y_position;
};
NewKnownLandmark initialise_known(const PointFunctions& point, const KnownLandmark& known,
                                  const Eigen::Vector3d& anchor);

}  // namespace slammot
