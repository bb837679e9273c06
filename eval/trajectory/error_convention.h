// The pose error that a covariance of another program is about, and its conversion to ours:
// e = [dr (W), dtheta (C, right: R_true = R_est Exp(dtheta))], to first order e = J e_other and
// P = J P_other J'.
#pragma once

#include <string>
#include <vector>

#include "models/camera_motion.h"

namespace slammot {

struct ErrorConvention {
  enum class Order { kPositionFirst, kRotationFirst };
  // R_true = R_est Exp(dtheta), or Exp(dtheta) R_est.
  enum class Rotation { kRight, kLeft };
  // r_true = r_est + dr; r_est + R_est dr; or that of T_true = Exp(dr, dtheta) T_est, which turns
  // r_est too and so goes with a left rotation.
  enum class Position { kGlobal, kLocal, kSpatial };

  Order order = Order::kPositionFirst;
  Rotation rotation = Rotation::kRight;
  Position position = Position::kGlobal;

  bool operator==(const ErrorConvention&) const = default;
};

// `ORDER,ROTATION,POSITION`: position-first or rotation-first; right or left; global, local or
// spatial. Throws std::invalid_argument.
ErrorConvention parse_error_convention(const std::string& text);
std::string to_string(const ErrorConvention& convention);

std::vector<ErrorConvention> error_conventions();  // all that there are

Matrix6d to_our_error(const Matrix6d& P, const ErrorConvention& convention,
                      const CameraState& estimate);

}  // namespace slammot
