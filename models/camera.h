// A camera: image size, intrinsics, and one of the lens models, each mapping the normalised image
// plane (x/z, y/z) to the distorted plane: pixel = c + f * distorted.
//
// Lens models are small types with the members of the concept `Lens`; adding one is one struct and
// one entry of the variant `LensModel`. Camera frame: x right, y down, z forward.
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "models/lens.h"

namespace slammot {

using LensModel =
    std::variant<PinholeLens, RadtanLens, RationalLens, EquidistantLens, DoubleSphereLens>;

struct Projection {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> J_pixel_ray;  // with respect to the ray in the camera frame
};

struct Bearing {
  Eigen::Vector3d ray;  // in the camera frame, z = 1
  Eigen::Matrix<double, 3, 2> J_ray_pixel;
};

struct Camera {
  int width = 640;
  int height = 480;
  double fx = 1.0, fy = 1.0, cx = 0.0, cy = 0.0;  // [px]
  LensModel lens;

  // The pixel of a ray of any length; nothing if it does not point forward (z > 0).
  std::optional<Projection> project(const Eigen::Vector3d& ray) const;

  // The ray of a pixel, found by Newton's method on the lens; nothing where the lens has no
  // inverse.
  std::optional<Bearing> unproject(const Eigen::Vector2d& pixel) const;

  bool in_image(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < width - 0.5 &&
           pixel.y() < height - 0.5;
  }
};

// The lens of a name or an alias (lens.h), with its coefficients: fewer are followed by zeros, and
// zeros beyond the last count for nothing. Throws std::invalid_argument with a reason.
LensModel make_lens(std::string_view name, std::span<const double> distortion);
std::string_view lens_name(const LensModel& lens);
std::span<const double> lens_distortion(const LensModel& lens);

}  // namespace slammot
