// From the poses of a body, as of an IMU, to those of the camera that is fixed to it.
#pragma once

#include <filesystem>

#include "estimation/estimator.h"

namespace slammot {

// A file of one row `tx ty tz qx qy qz qw`: T_BC, the camera in the body [m]. Throws InputError.
Eigen::Isometry3d read_extrinsics(const std::filesystem::path& file);

// T_WC = T_WB T_BC, and the covariance of the pose: with [dr (W), dtheta (B, right)] of the body,
// dr_C = dr - R_WB [t_BC]x dtheta and dtheta_C = R_BC' dtheta.
void to_camera(const Eigen::Isometry3d& T_body_camera, CameraEstimate& estimate);

}  // namespace slammot
