// A lens, as docs/extending.md adds one: what stands between the `example` and `end` lines is
// named there, and that it compiles is half the test.
#include <gtest/gtest.h>

#include "models/camera.h"

namespace slammot {
namespace {

// [example: lens]
// The division model (Fitzgibbon 2001), undistorted = distorted / (1 + k |distorted|^2), solved for
// the distorted point.
struct DivisionLens {
  static constexpr std::string_view kName = "division";
  std::array<double, 1> coefficients{};

  template <typename T>
  Vector2<T> distort(const Vector2<T>& x) const {
    using std::sqrt;
    return x * (T(2.0) / (T(1.0) + sqrt(T(1.0) - T(4.0 * coefficients[0]) * x.squaredNorm())));
  }

  Eigen::Matrix2d jacobian(const Eigen::Vector2d& x) const {
    const double k = coefficients[0];
    const double root = std::sqrt(1.0 - 4.0 * k * x.squaredNorm());
    const double scale = 2.0 / (1.0 + root);
    const double slope = 4.0 * k / (root * (1.0 + root) * (1.0 + root));  // d scale / d |x|^2
    return scale * Eigen::Matrix2d::Identity() + 2.0 * slope * x * x.transpose();
  }
};
// [end]

TEST(ExtendingLens, IsItsDefinitionAndHasItsJacobian) {
  const DivisionLens lens{{-0.2}};
  for (const Eigen::Vector2d& x :
       {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.3, -0.4), Eigen::Vector2d(-1.0, 0.7)}) {
    const Eigen::Vector2d d = lens.distort(x);
    EXPECT_LT((d / (1.0 + lens.coefficients[0] * d.squaredNorm()) - x).norm(), 1e-14);
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector2d step = 1e-5 * Eigen::Vector2d::Unit(i);
      const Eigen::Vector2d numeric =
          (lens.distort(Eigen::Vector2d(x + step)) - lens.distort(Eigen::Vector2d(x - step))) /
          2e-5;
      EXPECT_LT((numeric - lens.jacobian(x).col(i)).norm(), 1e-8);
    }
  }
}

}  // namespace
}  // namespace slammot
