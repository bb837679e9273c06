#include "models/camera.h"

#include <algorithm>
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

// `visit(lens)` of each lens of the variant, without coefficients, until it gives true.
template <typename Visit, std::size_t... I>
bool any_lens(const Visit& visit, std::index_sequence<I...>) {
  return (visit(std::variant_alternative_t<I, LensModel>{}) || ...);
}
constexpr auto kLenses = std::make_index_sequence<std::variant_size_v<LensModel>>();

std::string known_lenses() {
  std::string text;
  any_lens(
      [&](const auto& lens) {
        text += (text.empty() ? "" : ", ") + std::string(lens.kName) + " (also";
        for (const std::string_view alias : lens.kAliases) text += " " + std::string(alias);
        text += ")";
        return false;
      },
      kLenses);
  return text;
}

std::span<const double> without_zeros(std::span<const double> distortion, std::size_t kept) {
  while (distortion.size() > kept && distortion.back() == 0.0) {
    distortion = distortion.first(distortion.size() - 1);
  }
  return distortion;
}

template <typename Lens>
Lens lens_of(std::span<const double> stated) {
  Lens lens{};
  auto& coefficients = lens.coefficients;
  const auto distortion = without_zeros(stated, coefficients.size());
  if (distortion.size() > coefficients.size()) {
    const bool rational = std::is_same_v<Lens, RadtanLens> && distortion.size() <= 8;
    throw std::invalid_argument(
        "camera model '" + std::string(lens.kName) + "' takes at most " +
        std::to_string(coefficients.size()) + " distortion coefficients, not " +
        std::to_string(distortion.size()) + (rational ? ": the model 'rational' takes 8" : ""));
  }
  std::ranges::copy(distortion, coefficients.begin());
  return lens;
}

}  // namespace

LensModel make_lens(std::string_view name, std::span<const double> distortion) {
  LensModel found;
  const auto take = [&](const auto& lens) {
    if (name != lens.kName && std::ranges::count(lens.kAliases, name) == 0) return false;
    found = lens_of<std::decay_t<decltype(lens)>>(distortion);
    return true;
  };
  if (any_lens(take, kLenses)) return found;
  throw std::invalid_argument("unknown camera model '" + std::string(name) +
                              "' (known: " + known_lenses() + ")");
}

std::string_view lens_name(const LensModel& lens) {
  return std::visit([](const auto& model) { return model.kName; }, lens);
}

std::span<const double> lens_distortion(const LensModel& lens) {
  return std::visit([](const auto& model) { return std::span<const double>(model.coefficients); },
                    lens);
}

}  // namespace slammot
