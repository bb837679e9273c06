// The laws that every model of a moving landmark keeps; a new one inherits them through
// models/landmarks/all_models.h.
#include <Eigen/LU>

#include "models/landmarks/all_models.h"
#include "models/landmarks/landmark_models.h"
#include "tests/models/fixture.h"

namespace slammot {
namespace {

using test::Jet;

template <typename>
struct WithEvery;
template <typename... P>
struct WithEvery<std::tuple<P...>> {
  using Type = decltype(std::tuple_cat(LandmarkModels<P>{}...));
};

template <typename M>
class LandmarkLaws : public testing::Test {
 protected:
  using X = StateOf<M>;
  using P = typename M::Point;

  // Every seventh is at rest.
  X random_state() {
    X x;
    for (int i = 3; i < x.size(); ++i) x(i) = count_ % 7 == 0 ? 0.0 : random_.normal();
    ++count_;
    x.template head<3>() = test::random_point<P>(random_);
    return x;
  }
  static Eigen::Vector3d y(const X& x) { return x.template head<3>(); }
  static Eigen::Vector3d direction(const X& x) { return P::direction(y(x)); }
  static double rho(const X& x) { return P::inverse_depth(y(x)); }
  Eigen::Vector3d position(const X& x) const {
    return position_world(row_.point, Eigen::Vector3d::Zero(), y(x));
  }

  const LandmarkFunctions& row_ = find_landmark(std::string(M::kName), std::string(P::kName));

  test::Random random_;
  int count_ = 0;
};
TYPED_TEST_SUITE(LandmarkLaws, test::TypesOf<WithEvery<PointParametrisations>::Type>::Type);

TYPED_TEST(LandmarkLaws, JacobianIsThatOfThePrediction) {
  constexpr int kDim = kLandmarkDim<TypeParam>;
  for (int k = 0; k < test::kStates; ++k) {
    const StateOf<TypeParam> x = this->random_state();
    const double dt = this->random_.uniform(0.01, 0.2);
    StateOf<TypeParam, Jet<kDim>> x_jet;
    for (int i = 0; i < kDim; ++i) x_jet(i) = Jet<kDim>(x(i), i);
    const JacobianOf<TypeParam> F = test::derivatives<kDim, kDim>(TypeParam::predict(x_jet, dt));
    test::expect_same(TypeParam::predict_jacobian(x, dt), F, "prediction");
  }
}

// d(position, velocity)/dx times d x/d(position, velocity, ..) = (I 0).
TYPED_TEST(LandmarkLaws, NoiseStandsInMetres) {
  constexpr int kDim = kLandmarkDim<TypeParam>;
  for (int k = 0; k < test::kStates; ++k) {
    const StateOf<TypeParam> x = this->random_state();
    if (std::abs(this->rho(x)) < 1e-3) continue;
    Eigen::Matrix<double, 6, kDim> J_metric = Eigen::Matrix<double, 6, kDim>::Zero();
    J_metric.template topLeftCorner<3, 3>() = position_jacobian(this->row_.point, this->y(x));
    J_metric.template bottomRows<3>() = TypeParam::velocity_jacobian(x);
    const Eigen::Matrix<double, 6, kDim> I = J_metric * TypeParam::noise_jacobian(x);
    const Eigen::Matrix<double, 6, kDim> expected = Eigen::Matrix<double, 6, kDim>::Identity();
    ASSERT_LT((I - expected).cwiseAbs().maxCoeff(), 1e-7) << x.transpose();
  }
}

TYPED_TEST(LandmarkLaws, TwoHalfStepsAreOne) {
  for (int k = 0; k < test::kStates; ++k) {
    const StateOf<TypeParam> x = this->random_state();
    const double dt = this->random_.uniform(0.01, 0.2);
    const StateOf<TypeParam> whole = TypeParam::predict(x, dt);
    const StateOf<TypeParam> half = TypeParam::predict(x, 0.5 * dt);
    const StateOf<TypeParam> halves = TypeParam::predict(half, 0.5 * dt);
    const double scale = 1.0 + whole.norm();
    // Past the vertical theta may differ by a full turn.
    const Eigen::Vector3d turned = this->direction(halves) - this->direction(whole);
    EXPECT_LT(turned.norm(), 1e-9) << x.transpose();
    EXPECT_NEAR(this->rho(halves), this->rho(whole), 1e-9 * scale);
    EXPECT_LT((halves - whole).template tail<TypeParam::kMotion>().norm(), 1e-9 * scale);
  }
}

TYPED_TEST(LandmarkLaws, ThePointMovesByItsVelocity) {
  constexpr double kStep = 1e-4;  // [s]
  for (int k = 0; k < test::kStates; ++k) {
    const StateOf<TypeParam> x = this->random_state();
    if (std::abs(this->rho(x)) < 0.05) continue;
    const Eigen::Vector3d moved = this->position(TypeParam::predict(x, kStep)) -
                                  this->position(TypeParam::predict(x, -kStep));
    const Eigen::Vector3d v = TypeParam::velocity(x);
    EXPECT_LT((moved / (2.0 * kStep) - v).norm(), 1e-6 * (1.0 + v.norm())) << x.transpose();
  }
}

// In a world `s` times as large.
TYPED_TEST(LandmarkLaws, ItsMotionIsOfTheScaleItSays) {
  static constexpr double s = 1.7;
  const auto scaled = [this](const StateOf<TypeParam>& x) {
    StateOf<TypeParam> result = x;
    const double rho = this->rho(x) / s;
    result.template head<3>() = TypeParam::Point::of(this->direction(x), rho, this->y(x));
    if (TypeParam::kMotionInMetres) result.template tail<TypeParam::kMotion>() *= s;
    return result;
  };
  for (int k = 0; k < test::kStates; ++k) {
    const StateOf<TypeParam> x = this->random_state();
    const StateOf<TypeParam> there = TypeParam::predict(scaled(x), 0.1);
    const StateOf<TypeParam> here = scaled(TypeParam::predict(x, 0.1));
    EXPECT_LT((this->direction(there) - this->direction(here)).norm(), 1e-9) << x.transpose();
    EXPECT_NEAR(this->rho(there), this->rho(here), 1e-9 * (1.0 + x.norm()));
    EXPECT_LT((there - here).template tail<TypeParam::kMotion>().norm(), 1e-9 * (1.0 + x.norm()));
  }
}

TYPED_TEST(LandmarkLaws, MotionOfAVelocityHasThisVelocity) {
  for (int k = 0; k < test::kStates; ++k) {
    StateOf<TypeParam> x = this->random_state();
    if (std::abs(this->rho(x)) < 1e-3) continue;
    const Eigen::Vector3d v = this->random_.vector(1.0);
    x.template tail<TypeParam::kMotion>() = TypeParam::motion_of(x.template head<3>(), v);
    EXPECT_LT((TypeParam::velocity(x) - v).norm(), 1e-9);
    const StateOf<TypeParam> next = TypeParam::predict(x, 0.1);
    EXPECT_LT((TypeParam::velocity(next) - v).norm(), 1e-9 * (1.0 + v.norm()));
  }
}

// The density of v at rest is that of the first three of w times |dw/dv|.
TYPED_TEST(LandmarkLaws, DensityScaleIsTheDeterminant) {
  for (int k = 0; k < test::kStates; ++k) {
    StateOf<TypeParam> x = this->random_state();
    if (std::abs(this->rho(x)) < 0.05) continue;
    x.template tail<TypeParam::kMotion>().setZero();
    const Eigen::Matrix3d dv_dw = TypeParam::velocity_jacobian(x).template middleCols<3>(3);
    EXPECT_NEAR(TypeParam::density_scale(x) * std::abs(dv_dw.determinant()), 1.0, 1e-9);
  }
}

TYPED_TEST(LandmarkLaws, ItsRowIsTheModel) {
  const LandmarkFunctions& row = this->row_;
  EXPECT_EQ(row.motion, TypeParam::kMotion);
  EXPECT_EQ(row.dim(), kLandmarkDim<TypeParam>);
  EXPECT_EQ(row.motion_in_metres, TypeParam::kMotionInMetres);
  EXPECT_TRUE(row.can_move);
  const LandmarkPrior prior;
  for (int k = 0; k < 20; ++k) {
    const StateOf<TypeParam> x = this->random_state();
    EXPECT_TRUE(row.predict(x, 0.1) == TypeParam::predict(x, 0.1));
    EXPECT_TRUE(row.predict_jacobian(x, 0.1) == TypeParam::predict_jacobian(x, 0.1));
    EXPECT_TRUE(row.noise_root(x, prior, 0.1) == landmark_noise_root<TypeParam>(x, prior, 0.1));
  }
  EXPECT_GT(row.prior_sigmas(prior).minCoeff(), 0.0);
}

TEST(LandmarkPrior, SteadyTimeBoundsTheNoiseOfWhatIsNotKnownToMove) {
  LandmarkPrior prior;
  prior.max_speed = 4.0;
  prior.acceleration = 3.0;
  prior.jerk = 0.1;
  prior.steady_time = 10.0;
  EXPECT_EQ(prior.noise(true).acceleration, 3.0);
  EXPECT_DOUBLE_EQ(prior.noise(false).acceleration, 0.2);
  EXPECT_DOUBLE_EQ(prior.noise(false).jerk, 0.1);
  prior.jerk = 5.0;
  EXPECT_DOUBLE_EQ(prior.noise(false).jerk, 0.3);
  prior.acceleration = 0.1;
  EXPECT_EQ(prior.noise(false).acceleration, 0.1);
  prior.steady_time = 0.0;
  prior.acceleration = 3.0;
  EXPECT_EQ(prior.noise(false).acceleration, 3.0);
}

// Jerk that is white over dt, integrated in small steps of constant jerk.
TEST(ConstantAcceleration, NoiseIsThatOfWhiteJerk) {
  constexpr double kDt = 0.1;
  constexpr int kSteps = 2000;
  const double h = kDt / kSteps;
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero(), F;
  F << 1.0, h, 0.5 * h * h, 0.0, 1.0, h, 0.0, 0.0, 1.0;
  const Eigen::Vector3d g(h * h * h / 6.0, 0.5 * h * h, h);
  // The jerk of a small step has the variance that makes that of a whole step's acceleration dt^2.
  const double variance = kDt / h;
  for (int i = 0; i < kSteps; ++i) P = F * P * F.transpose() + variance * g * g.transpose();
  const Eigen::Matrix3d pattern = ConstantAcceleration<InverseDepth>::jerk_pattern(kDt);
  EXPECT_LT((P - pattern).cwiseQuotient(pattern).cwiseAbs().maxCoeff(), 2e-3);
}

}  // namespace
}  // namespace slammot
