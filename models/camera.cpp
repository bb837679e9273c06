#include "models/camera.h"

#include <stdexcept>

namespace slammot {

std::optional<Projection> Camera::project(const Eigen::Vector3d& ray) const {
  if (!(ray.z() > 0.0)) return std::nullopt;
  const double inverse_z = 1.0 / ray.z();
  const Eigen::Vector2d x = ray.head<2>() * inverse_z;
  Eigen::Matrix<double, 2, 3> J_x_ray;
  J_x_ray << inverse_z, 0.0, -x.x() * inverse_z, 0.0, inverse_z, -x.y() * inverse_z;
  return std::visit(
      [&](const auto& model) {
        const Eigen::Vector2d d = model.distort(x);
        const Eigen::Vector2d f(fx, fy);
        return Projection{Eigen::Vector2d(cx + fx * d.x(), cy + fy * d.y()),
                          f.asDiagonal() * model.jacobian(x) * J_x_ray};
      },
      lens);
}

namespace {

// Newton's method from the distorted point; the lens is close to the identity near the axis.
template <typename Lens>
std::optional<Eigen::Vector2d> undistort(const Lens& lens, const Eigen::Vector2d& distorted) {
  Eigen::Vector2d x = distorted;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d error = lens.distort(x) - distorted;
    if (!error.allFinite()) return std::nullopt;
    if (error.squaredNorm() < 1e-28) return x;
    const Eigen::Matrix2d J = lens.jacobian(x);
    if (!(std::abs(J.determinant()) > 1e-6)) return std::nullopt;
    const Eigen::Vector2d step = J.inverse() * error;
    const double length = step.norm();
    x -= length > 0.5 ? Eigen::Vector2d(step * (0.5 / length)) : step;
  }
  const bool solved = (lens.distort(x) - distorted).norm() < 1e-10;
  return solved ? std::optional(x) : std::nullopt;
}

}  // namespace

std::optional<Bearing> Camera::unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  return std::visit(
      [&](const auto& model) -> std::optional<Bearing> {
        const auto x = undistort(model, distorted);
        if (!x) return std::nullopt;
        Bearing bearing;
        bearing.ray = x->homogeneous();
        bearing.J_ray_pixel.setZero();
        bearing.J_ray_pixel.topRows<2>() =
            model.jacobian(*x).inverse() * Eigen::Vector2d(1.0 / fx, 1.0 / fy).asDiagonal();
        return bearing;
      },
      lens);
}

namespace {

// Each lens of the variant in turn, until one has the name.
template <std::size_t I = 0>
LensModel find_lens(std::string_view name, std::span<const double> distortion) {
  if constexpr (I == std::variant_size_v<LensModel>) {
    throw std::invalid_argument("unknown camera model '" + std::string(name) +
                                "' (known: pinhole, radtan, which others call plumb_bob or "
                                "Brown-Conrady, and equidistant, also called fisheye)");
  } else {
    using Lens = std::variant_alternative_t<I, LensModel>;
    if (name != Lens::kName) return find_lens<I + 1>(name, distortion);
    Lens lens{};
    if (distortion.size() > lens.coefficients.size()) {
      throw std::invalid_argument("camera model '" + std::string(name) + "' takes at most " +
                                  std::to_string(lens.coefficients.size()) +
                                  " distortion coefficients, not " +
                                  std::to_string(distortion.size()));
    }
    for (std::size_t i = 0; i < distortion.size(); ++i) lens.coefficients[i] = distortion[i];
    return lens;
  }
}

}  // namespace

LensModel make_lens(std::string_view name, std::span<const double> distortion) {
  return find_lens(name, distortion);
}

std::string_view lens_name(const LensModel& lens) {
  return std::visit([](const auto& model) { return model.kName; }, lens);
}

std::span<const double> lens_distortion(const LensModel& lens) {
  return std::visit([](const auto& model) { return std::span<const double>(model.coefficients); },
                    lens);
}

}  // namespace slammot
