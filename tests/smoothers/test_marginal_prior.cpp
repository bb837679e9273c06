// The marginal prior on its own, over a Euclidean variable and a rotating camera.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "smoothers/graph/camera_manifold.h"
#include "smoothers/graph/prior.h"
#include "tests/smoothers/fixture.h"

namespace slammot {
namespace {

// A prior over (w, motion of a camera), whose variables have moved on from where it was set.
struct Moved {
  MotionManifold manifold;
  Variable w, motion;
  Prior prior;

  explicit Moved(bool first_estimates) : prior{MarginalPrior(first_estimates), {}} {
    std::srand(3);
    w.id = 1;
    w.value = Eigen::Vector3d(0.3, -0.2, 0.1);
    motion.id = 2;
    motion.manifold = &manifold;
    Eigen::Vector3d position;
    motion.value.resize(kMotionSize);
    camera_to_blocks(test::camera_at(0.3, 0.2), position.data(), motion.value.data());
    const Eigen::MatrixXd R =
        Eigen::MatrixXd::Random(12, 12).triangularView<Eigen::Upper>().toDenseMatrix() +
        3.0 * Eigen::MatrixXd::Identity(12, 12);
    prior.active.set({&w, &motion}, R, Eigen::VectorXd::Random(12));
    const SmallVector d = 0.3 * Eigen::VectorXd::Random(kMotionDim);
    motion.value = plus(&manifold, motion.value, d);
    w.value += Eigen::Vector3d(0.1, 0.1, -0.2);
  }
};

TEST(MarginalPrior, JacobianIsTheDerivativeOfTheResidual) {
  Moved at(false);
  const Eigen::MatrixXd J = at.prior.active.jacobian();
  const SmallVector value = at.motion.value;
  for (int i = 0; i < kMotionDim; ++i) {
    constexpr double kStep = 1e-6;
    const SmallVector d = kStep * Eigen::VectorXd::Unit(kMotionDim, i);
    at.motion.value = plus(&at.manifold, value, d);
    const Eigen::VectorXd ahead = at.prior.active.residual();
    at.motion.value = plus(&at.manifold, value, -d);
    const Eigen::VectorXd behind = at.prior.active.residual();
    EXPECT_LT(((ahead - behind) / (2.0 * kStep) - J.col(3 + i)).norm(), 1e-8) << "column " << i;
  }
}

TEST(MarginalPrior, NormalEquationsAreThoseOfResidualAndJacobian) {
  for (const bool first_estimates : {false, true}) {
    const Moved at(first_estimates);
    const Eigen::MatrixXd J = at.prior.active.jacobian();
    const Eigen::VectorXd r = at.prior.active.residual();
    Eigen::MatrixXd H(12, 12);
    Eigen::VectorXd g(12);
    at.prior.active.normal_equations(H, g);
    EXPECT_LT((H - J.transpose() * J).norm(), 1e-12 * H.norm());
    EXPECT_LT((g - J.transpose() * r).norm(), 1e-12 * g.norm());
    EXPECT_NEAR(at.prior.active.square(), r.squaredNorm(), 1e-12 * r.squaredNorm());
  }
}

TEST(MarginalPrior, RelinearisedItSaysTheSameHere) {
  for (const bool first_estimates : {false, true}) {
    Moved at(first_estimates);
    const Eigen::MatrixXd J = at.prior.active.jacobian();
    const Eigen::VectorXd r = at.prior.active.residual();
    at.prior.relinearise();
    EXPECT_EQ(at.prior.active.difference().norm(), 0.0);
    EXPECT_LT((at.prior.active.residual() - r).norm(), 1e-12 * r.norm());
    EXPECT_LT((at.prior.active.jacobian() - J).norm(), 1e-12 * J.norm());
    Eigen::MatrixXd H(12, 12);
    Eigen::VectorXd g(12);
    at.prior.active.normal_equations(H, g);
    EXPECT_LT((H - J.transpose() * J).norm(), 1e-12 * H.norm());
  }
}

// With first estimates the Jacobian is the one at b0, wherever the variables are.
TEST(MarginalPrior, FirstEstimatesDoNotTurn) {
  const Moved fixed(true), turned(false);
  Moved there(true);
  there.prior.relinearise();
  EXPECT_EQ((fixed.prior.active.jacobian() - there.prior.active.jacobian()).norm(), 0.0);
  EXPECT_GT((fixed.prior.active.jacobian() - turned.prior.active.jacobian()).norm(), 1e-2);
}

TEST(MarginalPrior, ConditionedOnZeroItIsTheResidualThere) {
  Moved at(false);
  at.w.value.setZero();
  const Eigen::VectorXd r = at.prior.active.residual();
  const Eigen::MatrixXd J = at.prior.active.jacobian();
  at.prior.condition_on_zero(at.w.id);
  EXPECT_EQ(at.prior.active.find(at.w.id), nullptr);
  EXPECT_EQ(at.prior.active.cols(), kMotionDim);
  EXPECT_LT((at.prior.active.residual() - r).norm(), 1e-12 * r.norm());
  EXPECT_LT((at.prior.active.jacobian() - J.rightCols(kMotionDim)).norm(), 1e-12 * J.norm());
  at.prior.condition_on_zero(99);  // of another variable: nothing to do
  EXPECT_EQ(at.prior.active.cols(), kMotionDim);
}

}  // namespace
}  // namespace slammot
