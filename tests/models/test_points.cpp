// The laws that every parametrisation of a point keeps; a new one inherits them through
// models/points/all_points.h.
#include "models/points/scale.h"
#include "tests/models/fixture.h"

namespace slammot {
namespace {

using test::Jet;

template <typename P>
struct PointLaws : testing::Test {
  Eigen::Vector3d random_y() { return test::random_point<P>(random); }
  test::Random random;
  const PointFunctions& row = find_point(std::string(P::kName));
};
TYPED_TEST_SUITE(PointLaws, test::TypesOf<PointParametrisations>::Type);

template <int N>
Vector3<Jet<N>> jets(const Eigen::Vector3d& y) {
  Vector3<Jet<N>> result;
  for (int i = 0; i < 3; ++i) result(i) = Jet<N>(y(i), i);
  return result;
}

TYPED_TEST(PointLaws, JacobiansOfTheRay) {
  for (int k = 0; k < test::kStates; ++k) {
    const Eigen::Vector3d y = this->random_y();
    const Vector3<Jet<3>> y_jet = jets<3>(y);
    test::expect_same(TypeParam::direction_jacobian(y),
                      test::derivatives<3, 3>(TypeParam::direction(y_jet)), "direction");
    const Vector3<Jet<3>> rho = Vector3<Jet<3>>::Constant(TypeParam::inverse_depth(y_jet));
    test::expect_same(TypeParam::inverse_depth_jacobian(y), (test::derivatives<1, 3>(rho)),
                      "inverse depth");
    EXPECT_NEAR(TypeParam::direction(y).norm(), 1.0, 1e-12);
  }
}

// Of the direction only that of g counts.
TYPED_TEST(PointLaws, OfInvertsTheRay) {
  for (int k = 0; k < test::kStates; ++k) {
    const Eigen::Vector3d y = this->random_y();
    const double rho = TypeParam::inverse_depth(y), length = this->random.uniform(0.1, 5.0);
    const Eigen::Vector3d g = length * TypeParam::direction(y);
    EXPECT_LT((TypeParam::of(g, rho, y) - y).norm(), 1e-9 * (1.0 + y.norm())) << y.transpose();
    const Matrix34d J = TypeParam::of_jacobian(g, rho);
    const Eigen::Vector4d along(g.x(), g.y(), g.z(), 0.0);
    EXPECT_LT((J * along).norm(), 1e-9 * J.norm());
    Vector3<Jet<4>> g_jet = jets<4>(g);
    const Vector3<Jet<4>> near = y.cast<Jet<4>>();
    test::expect_same(J, test::derivatives<3, 4>(TypeParam::of(g_jet, Jet<4>(rho, 3), near)), "of");
  }
}

TYPED_TEST(PointLaws, ExistsWhereItIsANumber) {
  const Eigen::Vector3d ahead(0.3, 0.2, 2.0), zero = Eigen::Vector3d::Zero();
  for (const double rho : {-0.5, -1e-9, 0.0, 1e-9, 0.5}) {
    const Eigen::Vector3d y = TypeParam::of(ahead, rho, zero);
    const bool is_that_point = y.allFinite() && TypeParam::of_jacobian(ahead, rho).allFinite() &&
                               std::abs(TypeParam::inverse_depth(y) - rho) < 1e-12;
    EXPECT_EQ(TypeParam::exists(ahead, rho), is_that_point) << rho;
  }
  const Eigen::Vector3d down = Eigen::Vector3d::UnitY();
  EXPECT_EQ(TypeParam::exists(down, 0.5), TypeParam::of_jacobian(down, 0.5).allFinite());
}

// Else a smoother leaves a residual out of its linearisation error, or counts one too many.
TYPED_TEST(PointLaws, LinearDepthHasOneJacobian) {
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ(), zero = Eigen::Vector3d::Zero();
  const auto J = [&](double rho) {
    return TypeParam::inverse_depth_jacobian(TypeParam::of(ahead, rho, zero));
  };
  EXPECT_EQ(TypeParam::kLinearDepth, J(0.2) == J(0.4));
}

TYPED_TEST(PointLaws, ThereAndBack) {
  for (int k = 0; k < test::kStates; ++k) {
    const Eigen::Vector3d anchor = this->random.vector(5.0), d = this->random.vector(4.0);
    const Eigen::Vector3d y = point_at(this->row, d);
    EXPECT_LT((position_world(this->row, anchor, y) - anchor - d).norm(), 1e-12 * (1 + d.norm()));
    const Eigen::Matrix3d I = position_jacobian(this->row, y) * point_at_jacobian(this->row, d);
    EXPECT_LT((I - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  }
}

// In a world of another scale a direction stays, and depths grow.
TYPED_TEST(PointLaws, AChangeOfScale) {
  constexpr double kStep = 1e-6;
  const Eigen::Vector3d g = Eigen::Vector3d(0.3, -0.2, 0.9).normalized();
  const Eigen::Vector3d y = TypeParam::of(g, 0.4, Eigen::Vector3d::Zero().eval());
  const PointRay ray = this->row.ray(scaled(this->row, y, 0.7));
  EXPECT_LT((ray.direction - g).norm(), 1e-12);
  EXPECT_NEAR(ray.inverse_depth, 0.4 * std::exp(-0.7), 1e-12);
  EXPECT_LT((scaled(this->row, scaled(this->row, y, 0.5), -0.5) - y).norm(), 1e-12);
  const auto difference = [&](const Eigen::Vector3d& d, double t, double dt) -> Eigen::Vector3d {
    return (scaled(this->row, y + d, t + dt) - scaled(this->row, y - d, t - dt)) / (2.0 * kStep);
  };
  const Eigen::Matrix3d J = scaled_jacobian(this->row, y, 0.3);
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT((difference(kStep * Eigen::Vector3d::Unit(k), 0.3, 0.0) - J.col(k)).norm(), 1e-8);
  }
  const Eigen::Vector3d along = difference(Eigen::Vector3d::Zero(), 0.0, kStep);
  EXPECT_LT((along - along_scale(this->row, y)).norm(), 1e-8);
}

TYPED_TEST(PointLaws, ItsRowIsTheParametrisation) {
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d y = this->random_y();
    const PointRay ray = this->row.ray(y);
    EXPECT_EQ(ray.direction, TypeParam::direction(y));
    EXPECT_EQ(ray.J_direction, TypeParam::direction_jacobian(y));
    EXPECT_EQ(ray.inverse_depth, this->row.inverse_depth(y));
    EXPECT_EQ(ray.J_inverse_depth, this->row.inverse_depth_jacobian(y));
  }
  EXPECT_EQ(this->row.linear_depth, TypeParam::kLinearDepth);
}

}  // namespace
}  // namespace slammot
