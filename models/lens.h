// Lens models on the normalised plane: pinhole, radial-tangential (Brown-Conrady, as OpenCV) and
// its rational form, equidistant (Kannala-Brandt, as OpenCV's fisheye), double sphere.
//
// distort() is a template over its scalar; jacobian() is its derivative, 2x2. Both take x = (X/Z,
// Y/Z). `kAliases` are the names that other programs have for the same lens with the same order of
// coefficients.
#pragma once

#include <array>
#include <cmath>

#include "models/so3.h"

namespace slammot {

struct PinholeLens {
  static constexpr std::string_view kName = "pinhole";
  static constexpr std::array<std::string_view, 2> kAliases{"none", "Rectified"};
  std::array<double, 0> coefficients;

  template <typename T>
  Vector2<T> distort(const Vector2<T>& x) const {
    return x;
  }
  Eigen::Matrix2d jacobian(const Eigen::Vector2d&) const { return Eigen::Matrix2d::Identity(); }
};

// x times a radial factor, moved by the decentring p1, p2.
template <typename T>
Vector2<T> decentred(const Vector2<T>& x, const T& radial, double p1, double p2) {
  const T r2 = x.squaredNorm();
  const T xy = x.x() * x.y();
  return Vector2<T>(x.x() * radial + T(2.0 * p1) * xy + T(p2) * (r2 + T(2.0) * x.x() * x.x()),
                    x.y() * radial + T(p1) * (r2 + T(2.0) * x.y() * x.y()) + T(2.0 * p2) * xy);
}

// Its derivative; `slope` = d radial / d r^2.
inline Eigen::Matrix2d decentred_jacobian(const Eigen::Vector2d& x, double radial, double slope,
                                          double p1, double p2) {
  Eigen::Matrix2d J = 2.0 * slope * x * x.transpose();
  J(0, 0) += radial + 2.0 * p1 * x.y() + 6.0 * p2 * x.x();
  J(1, 1) += radial + 6.0 * p1 * x.y() + 2.0 * p2 * x.x();
  const double cross = 2.0 * (p1 * x.x() + p2 * x.y());
  J(0, 1) += cross;
  J(1, 0) += cross;
  return J;
}

// k1, k2, p1, p2, k3, in OpenCV's order.
struct RadtanLens {
  static constexpr std::string_view kName = "radtan";
  static constexpr std::array<std::string_view, 3> kAliases{"plumb_bob", "radial-tangential",
                                                            "PinHole"};
  std::array<double, 5> coefficients{};

  template <typename T>
  Vector2<T> distort(const Vector2<T>& x) const {
    const auto [k1, k2, p1, p2, k3] = coefficients;
    const T r2 = x.squaredNorm();
    return decentred<T>(x, T(1.0) + r2 * (T(k1) + r2 * (T(k2) + r2 * T(k3))), p1, p2);
  }

  Eigen::Matrix2d jacobian(const Eigen::Vector2d& x) const {
    const auto [k1, k2, p1, p2, k3] = coefficients;
    const double r2 = x.squaredNorm();
    return decentred_jacobian(x, 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)),
                              k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3), p1, p2);
  }
};

// k1, k2, p1, p2, k3 .. k6, in OpenCV's order: the radial factor of the first three k over that of
// the last three.
struct RationalLens {
  static constexpr std::string_view kName = "rational";
  static constexpr std::array<std::string_view, 2> kAliases{"rational_polynomial", "radtan8"};
  std::array<double, 8> coefficients{};

  template <typename T>
  Vector2<T> distort(const Vector2<T>& x) const {
    const auto [k1, k2, p1, p2, k3, k4, k5, k6] = coefficients;
    const T r2 = x.squaredNorm();
    const T above = T(1.0) + r2 * (T(k1) + r2 * (T(k2) + r2 * T(k3)));
    const T below = T(1.0) + r2 * (T(k4) + r2 * (T(k5) + r2 * T(k6)));
    return decentred<T>(x, above / below, p1, p2);
  }

  Eigen::Matrix2d jacobian(const Eigen::Vector2d& x) const {
    const auto [k1, k2, p1, p2, k3, k4, k5, k6] = coefficients;
    const double r2 = x.squaredNorm();
    const double below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
    const double radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / below;
    const double d_above = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
    const double d_below = k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6);
    return decentred_jacobian(x, radial, (d_above - radial * d_below) / below, p1, p2);
  }
};

// k1 .. k4: theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
struct EquidistantLens {
  static constexpr std::string_view kName = "equidistant";
  static constexpr std::array<std::string_view, 4> kAliases{"equi", "fisheye", "KannalaBrandt8",
                                                            "kb4"};
  std::array<double, 4> coefficients{};

  template <typename T>
  Vector2<T> distort(const Vector2<T>& x) const {
    using std::atan;
    using std::sqrt;
    const T r2 = x.squaredNorm();
    if (r2 < T(kSmall)) {
      // theta_d / r = 1 + (k1 - 1/3) r^2 + O(r^4)
      return x * (T(1.0) + T(coefficients[0] - 1.0 / 3.0) * r2);
    }
    const T r = sqrt(r2);
    const T theta = atan(r);
    return x * (theta * polynomial(theta * theta) / r);
  }

  Eigen::Matrix2d jacobian(const Eigen::Vector2d& x) const {
    const double r2 = x.squaredNorm();
    if (r2 < kSmall) {
      const double a = coefficients[0] - 1.0 / 3.0;
      return (1.0 + a * r2) * Eigen::Matrix2d::Identity() + 2.0 * a * x * x.transpose();
    }
    const double r = std::sqrt(r2);
    const double theta = std::atan(r);
    const double t2 = theta * theta;
    const auto [k1, k2, k3, k4] = coefficients;
    const double slope = 1.0 + t2 * (3.0 * k1 + t2 * (5.0 * k2 + t2 * (7.0 * k3 + t2 * 9.0 * k4)));
    const double scale = theta * polynomial(t2) / r;
    const double d_scale = (slope / (1.0 + r2) - scale) / r;  // d scale / d r
    return scale * Eigen::Matrix2d::Identity() + (d_scale / r) * x * x.transpose();
  }

 private:
  static constexpr double kSmall = 1e-8;

  template <typename T>
  T polynomial(const T& t2) const {
    const auto [k1, k2, k3, k4] = coefficients;
    return T(1.0) + t2 * (T(k1) + t2 * (T(k2) + t2 * (T(k3) + t2 * T(k4))));
  }
};

// xi, alpha (Usenko et al., 3DV 2018): the ray is projected to a sphere, to a second one whose
// centre is xi further, and then by a pinhole alpha / (1 - alpha) behind that.
struct DoubleSphereLens {
  static constexpr std::string_view kName = "double_sphere";
  static constexpr std::array<std::string_view, 1> kAliases{"ds"};
  std::array<double, 2> coefficients{};

  template <typename T>
  Vector2<T> distort(const Vector2<T>& x) const {
    using std::sqrt;
    const auto [xi, alpha] = coefficients;
    const T r2 = x.squaredNorm();
    const T z = T(xi) * sqrt(r2 + T(1.0)) + T(1.0);  // from the second centre
    return x / (T(alpha) * sqrt(r2 + z * z) + T(1.0 - alpha) * z);
  }

  Eigen::Matrix2d jacobian(const Eigen::Vector2d& x) const {
    const auto [xi, alpha] = coefficients;
    const double r2 = x.squaredNorm();
    const double first = std::sqrt(r2 + 1.0), z = xi * first + 1.0;
    const double second = std::sqrt(r2 + z * z), below = alpha * second + (1.0 - alpha) * z;
    const double d_z = xi / (2.0 * first);  // by r^2, as d_below
    const double d_below = alpha * (0.5 + z * d_z) / second + (1.0 - alpha) * d_z;
    return Eigen::Matrix2d::Identity() / below -
           2.0 * d_below / (below * below) * x * x.transpose();
  }
};

}  // namespace slammot
