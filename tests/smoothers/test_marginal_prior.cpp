// The marginal prior on its own, over Euclidean variables and orientations.
#include <gtest/gtest.h>

#include <random>

#include "tests/smoothers/fixture/cameras.h"
#include "tests/smoothers/fixture/prior_laws.h"

namespace slammot {
namespace {

// A prior over (w, q, u, p), q and p orientations, that have moved on from where it was set. In the
// core of the normal equations they stand in another order, with a gap.
struct Moved {
  static constexpr int kDim = 14;
  std::mt19937_64 engine{3};
  Variables variables;
  Variable* w = nullptr;
  Variable* q = nullptr;
  Variable* u = nullptr;
  Variable* p = nullptr;
  Prior prior;

  Eigen::VectorXd normals(Eigen::Index size) {
    std::normal_distribution<double> normal;
    return Eigen::VectorXd::NullaryExpr(size, [&] { return normal(engine); });
  }

  explicit Moved(bool fixed_points) : prior{MarginalPrior(fixed_points), {}} {
    w = &variables.add(Eigen::Vector3d(0.3, -0.2, 0.1), false, true);
    q = &variables.add(test::camera_at(0.3, 0.2).orientation.coeffs(), true, false);
    u = &variables.add(normals(5), false, false);
    p = &variables.add(test::camera_at(0.1, -0.4).orientation.coeffs(), true, false);
    w->core = 9;
    q->core = 0;
    u->core = 12;
    p->core = 3;
    Eigen::MatrixXd R = normals(kDim * kDim).reshaped(kDim, kDim).triangularView<Eigen::Upper>();
    R.diagonal().array() += 3.0;
    prior.active.set({w, q, u, p}, R, normals(kDim));
    variables.for_each([&](Variable& v) {
      v.step.setZero(v.dim());
      v.value = plus(v.is_orientation, v.value, 0.3 * normals(v.dim()));
    });
  }
  static constexpr int kCore = 17;

  void expect_normal_equations(const Eigen::MatrixXd& J, const Eigen::VectorXd& r) const {
    test::expect_normal_equations(prior.active, kCore, J, r, 1e-12);
  }
  // R is zero before the first column of each row that may not be.
  void expect_zero_before_starts() const {
    const std::vector<int>& starts = prior.active.starts();
    for (std::size_t i = 0; i < starts.size(); ++i) {
      EXPECT_EQ(prior.active.R().row(static_cast<int>(i)).head(starts[i]).norm(), 0.0);
    }
  }
};

TEST(MarginalPrior, JacobianIsTheDerivativeOfTheResidual) {
  Moved at(false);
  test::expect_jacobian_of_the_residual(at.prior.active, at.variables, 1e-8);
}

TEST(MarginalPrior, WithFixedPointsTheJacobianStays) {
  const Moved at(true);
  EXPECT_EQ(at.prior.active.jacobian(), Eigen::MatrixXd(at.prior.active.R()));
  EXPECT_TRUE(at.q->linearisation_point);
  EXPECT_NE(*at.q->linearisation_point, at.q->value);
  EXPECT_FALSE(Moved(false).q->linearisation_point);
}

TEST(MarginalPrior, NormalEquationsAreThoseOfResidualAndJacobian) {
  for (const bool fixed_points : {false, true}) {
    Moved at(fixed_points);
    const Eigen::MatrixXd J = at.prior.active.jacobian();
    const Eigen::VectorXd r = at.prior.active.residual();
    at.expect_normal_equations(J, r);
    at.expect_normal_equations(J, r);  // from the Gram that has been kept
    EXPECT_NEAR(at.prior.active.square(), r.squaredNorm(), 1e-12 * r.squaredNorm());
    const Eigen::MatrixXd K = at.normals(2 * Moved::kDim).reshaped(2, Moved::kDim);
    Eigen::MatrixXd E = Eigen::MatrixXd::Ones(Moved::kCore, 2);
    at.prior.active.add_transposed(K, E);
    E.array() -= 1.0;
    EXPECT_LT((E.transpose() - K * test::placed(at.prior.active, Moved::kCore)).norm(),
              1e-12 * K.norm());
  }
}

TEST(MarginalPrior, SquareAlongAStep) {
  for (const bool fixed_points : {false, true}) {
    Moved at(fixed_points);
    for (const auto& b : at.prior.active.blocks()) {
      Variable& v = at.variables[b.variable->id];
      v.step = at.normals(v.dim());
      v.candidate = plus(v.is_orientation, v.value, v.step);
    }
    const MarginalPrior& prior = at.prior.active;
    const double square = prior.square(&Variable::candidate);
    at.variables.for_each([](Variable& v) { v.value = v.candidate; });
    EXPECT_NEAR(square, prior.residual().squaredNorm(), 1e-12 * square);
  }
}

TEST(MarginalPrior, RelinearisedItSaysTheSameHere) {
  for (const bool fixed_points : {false, true}) {
    Moved at(fixed_points);
    const Eigen::MatrixXd J = at.prior.active.jacobian();
    const Eigen::VectorXd r = at.prior.active.residual();
    at.expect_normal_equations(J, r);
    test::expect_the_same_when_relinearised(at.prior);
    EXPECT_EQ(at.prior.active.difference().norm(), 0.0);
    at.expect_normal_equations(J, r);
    at.expect_zero_before_starts();
  }
}

TEST(MarginalPrior, ConditionedOnZeroItIsTheRest) {
  Moved at(false);
  const Eigen::MatrixXd J = at.prior.active.jacobian();
  at.w->value.setZero();
  const Eigen::VectorXd r = at.prior.active.residual();
  at.prior.condition_on_zero(at.w->id);
  EXPECT_EQ(at.prior.active.find(at.w->id), nullptr);
  EXPECT_EQ(at.prior.active.cols(), 11);
  EXPECT_EQ(at.prior.active.find(at.q->id)->offset, 0);
  EXPECT_LT((at.prior.active.residual() - r).norm(), 1e-12 * r.norm());
  EXPECT_LT((at.prior.active.jacobian() - J.rightCols(11)).norm(), 1e-12 * J.norm());
  at.prior.condition_on_zero(99);  // of another variable: nothing to do
  at.prior.condition_on_zero(at.u->id);
  EXPECT_EQ(at.prior.active.cols(), 6);
  EXPECT_EQ(at.prior.active.find(at.p->id)->offset, 3);
  at.expect_zero_before_starts();
}

// p(b) p(x | b), and of it the rows that were there.
TEST(MarginalPrior, JoinedItIsTheProduct) {
  Moved at(false);
  const Eigen::MatrixXd J = at.prior.active.jacobian();
  const Eigen::VectorXd r = at.prior.active.residual(), d = at.prior.active.difference();
  Variable& x = at.variables.add(at.normals(3), false, true);
  x.core = 20;
  const Eigen::VectorXd mean = at.normals(3);
  const Eigen::MatrixXd K = at.normals(3 * Moved::kDim).reshaped(3, Moved::kDim);
  Eigen::MatrixXd U = at.normals(9).reshaped(3, 3).triangularView<Eigen::Upper>(), KT = K;
  at.prior.active.chart().apply(KT);
  at.prior.active.join({&x}, mean, K, U);
  EXPECT_FALSE(x.is_private);
  EXPECT_EQ(at.prior.active.cols(), 3 + Moved::kDim);
  EXPECT_EQ(at.prior.active.find(x.id)->offset, 0);
  Eigen::VectorXd expected(3 + Moved::kDim);
  expected << U * (x.value - mean - K * d), r;
  EXPECT_LT((at.prior.active.residual() - expected).norm(), 1e-12 * expected.norm());
  Eigen::MatrixXd of_all = Eigen::MatrixXd::Zero(3 + Moved::kDim, 3 + Moved::kDim);
  of_all.topLeftCorner(3, 3) = U;
  of_all.topRightCorner(3, Moved::kDim) = -U * KT;
  of_all.bottomRightCorner(Moved::kDim, Moved::kDim) = J;
  EXPECT_LT((at.prior.active.jacobian() - of_all).norm(), 1e-12 * of_all.norm());
  for (int i = 0; i < 3 + Moved::kDim; ++i) {  // still a triangle, which costs less
    EXPECT_EQ(at.prior.active.starts()[static_cast<std::size_t>(i)], i);
  }
}

}  // namespace
}  // namespace slammot
