// A motion in metres whose prior and noise are in units of the landmark's distance: in a world of
// any scale they cost the same.
#include "smoothers/graph/chain_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>

#include "models/points/scale.h"
#include "tests/smoothers/fixture/cameras.h"

namespace slammot {
namespace {

constexpr double kTurn = 1e-6;

class ChainStepLaws : public testing::TestWithParam<std::tuple<const char*, const char*>> {
 protected:
  ChainStepLaws() {
    models.prior.inverse_depth = 0.3;
    const int dim = models.landmark->dim(), motion = models.landmark->motion;
    x = landmark_state(models.point().of({0.3, -0.2, 0.9}, 0.25, Eigen::Vector3d::Zero()),
                       MotionVector::LinSpaced(motion, 0.4, -0.3));
    step.dt = 0.1;
    step.G = models.landmark->noise_root(models.landmark->predict(x, step.dt), models.prior, 0.1);
    step.noise = LandmarkVector::LinSpaced(dim, -2.0, 1.5);
    step.unit = 0.2;  // not where it is now
  }
  // The same state in a world e^t as large.
  LandmarkVector scaled_state(double t) const {
    LandmarkVector s = x;
    s.head<3>() = scaled(models.point(), x.head<3>(), t);
    s.tail(models.landmark->motion) *= std::exp(t);
    return s;
  }
  LandmarkVector next(const LandmarkVector& from) const {
    return advance(models, step, from, step.noise);
  }

  GraphModels models{test::pinhole(),
                     2.0,
                     {},
                     &find_landmark(std::get<0>(GetParam()), std::get<1>(GetParam())),
                     /*noise_tells_scale=*/false};
  ChainStep step;
  LandmarkVector x;
};

TEST_P(ChainStepLaws, JacobianIsThatOfTheStep) {
  const LandmarkMatrix F = chain_jacobian(models, step, x, step.noise);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    LandmarkVector more = x, less = x;
    more(i) += kTurn;
    less(i) -= kTurn;
    const LandmarkVector slope = (next(more) - next(less)) / (2.0 * kTurn);
    EXPECT_LT((F.col(i) - slope).norm(), 1e-6) << "column " << i;
  }
}

TEST_P(ChainStepLaws, TakingTheUnitChangesNothingButG) {
  const LandmarkVector before = next(x);
  take_unit(models, x, step);
  EXPECT_LT((next(x) - before).norm(), 1e-12);
  EXPECT_LT((models.landmark->predict(x, step.dt) + step.G * step.noise - before).norm(), 1e-12);
}

TEST_P(ChainStepLaws, ANoiseIsAsLargeInAWorldOfAnyScale) {
  const int motion = models.landmark->motion;
  const MotionVector here = next(x).tail(motion);
  const MotionVector there = next(scaled_state(0.4)).tail(motion);
  EXPECT_LT((there - std::exp(0.4) * here).norm(), 1e-12);
  models.noise_tells_scale = true;
  step.unit = unit_of_motion(models, x.head<3>());
  EXPECT_GT((MotionVector(next(scaled_state(0.4)).tail(motion)) - std::exp(0.4) * here).norm(),
            0.01);
}

TEST_P(ChainStepLaws, FarAwayTheUnitStays) {
  x.head<3>() = models.point().of({0.3, -0.2, 0.9}, 1e-4, Eigen::Vector3d::Zero());
  EXPECT_DOUBLE_EQ(unit_of_motion(models, x.head<3>()), 0.003);
  EXPECT_TRUE(chain_jacobian(models, step, x, step.noise)
                  .isApprox(models.landmark->predict_jacobian(x, step.dt), 1e-12));
}

TEST_P(ChainStepLaws, ThePriorOfAMotionTellsNothingOfTheScale) {
  const int motion = models.landmark->motion;
  const MotionVector sigmas = MotionVector::LinSpaced(motion, 1.0, 2.5);
  MotionPrior prior;
  prior.sigmas = sigmas;
  prior.unit = 0.2;
  const auto r = [&](const LandmarkVector& at) {
    return motion_residual(models, prior, at.head<3>(), at.tail(motion));
  };
  linearise_motion_prior(models, x.head<3>(), x.tail(motion), prior);
  EXPECT_LT((r(x) - prior.r).norm(), 1e-12);
  EXPECT_LT((r(scaled_state(0.4)) - prior.r).norm(), 1e-12);
  const MotionVector along =
      prior.J_y * along_scale(models.point(), x.head<3>()) + prior.J_w.cwiseProduct(x.tail(motion));
  EXPECT_LT(along.norm(), 1e-12);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    LandmarkVector more = x, less = x;
    more(i) += kTurn;
    less(i) -= kTurn;
    const MotionVector slope = (r(more) - r(less)) / (2.0 * kTurn);
    const MotionVector column =
        i < 3 ? MotionVector(prior.J_y.col(i))
              : MotionVector(prior.J_w.cwiseProduct(MotionVector::Unit(motion, i - 3)));
    EXPECT_LT((column - slope).norm(), 1e-7) << "column " << i;
  }
  prior.unit = 0.0;  // in metres it does
  EXPECT_GT((r(scaled_state(0.4)) - r(x)).norm(), 0.1);
}

TEST(ChainStep, HasNoUnitWhereAMotionIsInUnitsOfTheDepth) {
  const GraphModels models{
      test::pinhole(), 2.0, {}, &find_landmark("scaled_velocity", "inverse_depth"), false};
  EXPECT_EQ(unit_of_motion(models, {0.0, 0.0, 0.25}), 0.0);
}

INSTANTIATE_TEST_SUITE_P(
    MotionsInMetres, ChainStepLaws,
    testing::Combine(testing::Values("dynamic_inverse_depth", "constant_acceleration"),
                     testing::Values("inverse_depth", "log_inverse_depth", "homogeneous", "xyz")),
    [](const auto& model) {
      return std::string(std::get<0>(model.param)) + "_" + std::get<1>(model.param);
    });

}  // namespace
}  // namespace slammot
