// The classifiers by themselves, on beliefs whose answer is known.
#include <gtest/gtest.h>

#include "estimation/classification.h"
#include "estimation/modules/outside_odds.h"
#include "models/landmarks/dynamic_inverse_depth.h"
#include "models/landmarks/scaled_velocity.h"
#include "models/points/inverse_depth.h"

namespace slammot {
namespace {

// w with the same sigma in each component.
MotionBelief belief(const Eigen::Vector3d& w, double sigma) {
  MotionBelief b;
  b.w = w;
  b.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  b.prior_sigmas = MotionVector::Ones(3);
  return b;
}

Label decide(const ClassifierOptions& options, const MotionBelief& b) {
  ClassifierMemory memory;
  return make_classifier(options, {})->decide(b, memory);
}

ClassifierOptions thesis() {
  ClassifierOptions options;
  options.name = "thesis";
  return options;
}

ClassifierOptions odds() {
  ClassifierOptions options;
  options.name = "odds";
  options.prior_odds = 1.0;
  options.decisive_odds = 100.0;
  return options;
}

// The labels just below a sigma at rest, or a speed, and just above.
void expect_of_sigma(const ClassifierOptions& options, double sigma, Label below, Label above) {
  EXPECT_EQ(decide(options, belief({0, 0, 0}, 0.999 * sigma)), below);
  EXPECT_EQ(decide(options, belief({0, 0, 0}, 1.001 * sigma)), above);
}
void expect_of_speed(const ClassifierOptions& options, double speed, double sigma) {
  EXPECT_EQ(decide(options, belief({0.999 * speed, 0, 0}, sigma)), Label::kUnknown);
  EXPECT_EQ(decide(options, belief({1.001 * speed, 0, 0}, sigma)), Label::kMoving);
}

TEST(Thesis, StaticWhenTheDensityAtRestExceedsItsThreshold) {
  // (2 pi)^-1.5 sigma^-3 = 1.6 (m/s)^-3 at sigma = 0.3411 m/s.
  const double limit = std::cbrt(std::pow(2.0 * M_PI, -1.5) / 1.6);
  EXPECT_NEAR(limit, 0.3411, 1e-4);
  expect_of_sigma(thesis(), limit, Label::kStatic, Label::kUnknown);
  // Off rest the density falls by exp(-C_m^2 / 2).
  EXPECT_NEAR(density_at_zero(Eigen::Vector3d(0.2, 0, 0), 0.01 * Eigen::Matrix3d::Identity()),
              std::exp(-2.0) / (std::pow(2.0 * M_PI, 1.5) * 1e-3), 1e-9);
}

TEST(Thesis, MovingWhenRestIsFurtherThanItsThreshold) {
  EXPECT_NEAR(
      mahalanobis_from_zero(Eigen::Vector3d(0.3, 0, 0.4), 0.01 * Eigen::Matrix3d::Identity()), 5.0,
      1e-12);
  expect_of_speed(thesis(), 3.583, 1.0);
}

TEST(Thesis, TheDensityIsThatOfTheVelocityInMetres) {
  // u = rho v: at rho = 0.1 a sigma of 0.03411 / s is one of 0.3411 m/s.
  Vector6d x;
  x << 0.1, 0.2, 0.1, 0, 0, 0;
  MotionBelief b = belief({0, 0, 0}, 0.0341);
  b.density_scale = ScaledVelocity<InverseDepth>::density_scale(x);
  EXPECT_NEAR(b.density_scale, 1e-3, 1e-15);
  EXPECT_EQ(decide(thesis(), b), Label::kStatic);
  b.covariance *= 1.01;
  EXPECT_EQ(decide(thesis(), b), Label::kUnknown);
  EXPECT_EQ(DynamicInverseDepth<InverseDepth>::density_scale(x), 1.0);
}

// At rest they are (prior sigma / sigma)^3; away from it, exp(-C_m^2 / 2) of that.
TEST(Odds, AreThePosteriorOverThePriorDensityAtRest) {
  expect_of_sigma(odds(), 1.0 / std::cbrt(100.0), Label::kStatic, Label::kUnknown);
  const double ratio = 4.0, limit = std::sqrt(2.0 * std::log(100.0 * 64.0));
  expect_of_speed(odds(), limit / ratio, 1.0 / ratio);
  EXPECT_EQ(decide(odds(), belief({1e3, 0, 0}, 1.0 / ratio)), Label::kMoving);  // density 0
  ClassifierOptions options = odds();
  options.prior_odds = 10.0;  // multiply: a factor of 10 suffices
  expect_of_sigma(options, 1.0 / std::cbrt(10.0), Label::kStatic, Label::kUnknown);
}

// A pixel has moved by nine sigmas, at a depth of which little is known: in metres a second the
// Gaussian reaches rest, and nothing at rest moves a pixel.
TEST(Odds, AreAskedOfWhatAPixelMeasures) {
  using Model = DynamicInverseDepth<InverseDepth>;
  constexpr auto kLandmark = landmark_row<Model>();
  const double rho = 0.15, rho_sigma = 0.1, u = 0.09, u_sigma = 0.01;  // [1/m], [1/s]
  const Eigen::Vector3d w(u / rho, 0.0, 0.0);
  const LandmarkVector x = landmark_state({0.0, 0.0, rho}, w);
  LandmarkMatrix P = LandmarkMatrix::Identity(6, 6) * 1e-6;
  P(2, 2) = rho_sigma * rho_sigma;
  P.block<3, 1>(3, 2) = -w / rho * P(2, 2);  // rho w is measured
  P.block<1, 3>(2, 3) = P.block<3, 1>(3, 2).transpose();
  P.block<3, 3>(3, 3) = w * w.transpose() * P(2, 2) / (rho * rho);
  P.block<3, 3>(3, 3).diagonal().array() += std::pow(u_sigma / rho, 2);

  MotionBelief asked = motion_belief(1, kLandmark, x, P);
  asked.prior_sigmas = MotionVector::Ones(3);
  ASSERT_TRUE(asked.seen);
  const double mean_square = std::hypot(rho, rho_sigma);
  EXPECT_NEAR(asked.seen->rho_w.x() / std::sqrt(asked.seen->covariance(0, 0)),
              u / u_sigma * rho / mean_square, 1e-6);
  EXPECT_DOUBLE_EQ(asked.seen->rho, mean_square);
  EXPECT_EQ(decide(odds(), asked), Label::kMoving);

  // The thesis asks for the velocity in metres.
  EXPECT_LT(mahalanobis_from_zero(asked.w, asked.covariance), 1.5);
  asked.seen.reset();
  EXPECT_EQ(decide(odds(), asked), Label::kStatic);
}

// At any depth, known or not, in every point parametrisation.
TEST(Odds, AreThePriorOnesWhereNothingWasMeasured) {
  const LandmarkPrior prior;
  for (const LandmarkFunctions& landmark : landmark_table()) {
    if (!landmark.can_move || !landmark.motion_in_metres) continue;
    const Eigen::Vector3d y = point_at(landmark.point, {0.5, 0.2, 3.0});
    const Eigen::RowVector3d J = landmark.point.inverse_depth_jacobian(y);
    for (const double rho_sigma : {0.01, 0.3, 3.0}) {
      SCOPED_TRACE(std::string(landmark.name) + ", " + std::string(landmark.point.name));
      const MotionVector sigmas = landmark.prior_sigmas(prior);
      LandmarkMatrix P = LandmarkMatrix::Zero(landmark.dim(), landmark.dim());
      P.topLeftCorner(3, 3) =
          rho_sigma * rho_sigma / std::pow(J.squaredNorm(), 2) * J.transpose() * J;
      P.bottomRightCorner(landmark.motion, landmark.motion) =
          sigmas.cwiseAbs2().asDiagonal().toDenseMatrix();
      MotionBelief asked =
          motion_belief(1, landmark, landmark_state(y, MotionVector::Zero(landmark.motion)), P);
      asked.prior_sigmas = sigmas;
      const auto log_ratio = log_odds_ratio_of_rest(asked);
      ASSERT_TRUE(log_ratio);
      EXPECT_NEAR(*log_ratio, 0.0, 1e-9);
    }
  }
}

// What is said from outside multiplies the ratio too, and without it nothing changes.
TEST(Odds, FromOutsideStandInPlaceOfThePriorOnes) {
  MotionBelief b = belief({0, 0, 0}, 1.001 / std::cbrt(10.0));
  EXPECT_EQ(decide(odds(), b), Label::kUnknown);  // 10 of the 100 that are asked for
  b.outside = OutsideOdds({{7, 0.95}}, 1.0).evidence(7);
  EXPECT_EQ(decide(odds(), b), Label::kStatic);
  b.outside = OutsideOdds({{7, 0.95}}, 19.0).evidence(7);  // as those of all others
  EXPECT_NEAR(b.outside, 0.0, 1e-12);
}

// What was called moving by odds from outside alone needs their and the decisive evidence, no more.
TEST(Odds, OfWhatWasOnlySaidToMoveAreThoseOfOneThatIsUnknown) {
  const auto classifier = make_classifier(odds(), {});
  ClassifierMemory memory;
  MotionBelief b = belief({0, 0, 0}, 0.99);
  b.outside = -std::log(1000.0);
  EXPECT_EQ(classifier->decide(b, memory), Label::kMoving);
  b.covariance = std::pow(1.001e-5, 2.0 / 3.0) * Eigen::Matrix3d::Identity();
  EXPECT_EQ(classifier->decide(b, memory), Label::kUnknown);
  b.covariance *= 0.99;
  EXPECT_EQ(classifier->decide(b, memory), Label::kStatic);
}

TEST(OutsideOdds, AreNeverCertain) {
  const OutsideOdds outside({{1, 0.0}, {2, 1.0}, {3, 0.8}}, 2.0);
  EXPECT_NEAR(std::exp(outside.evidence(1)), 1.0 / 99.0 / 2.0, 1e-12);
  EXPECT_NEAR(std::exp(outside.evidence(2)), 99.0 / 2.0, 1e-10);
  EXPECT_NEAR(std::exp(outside.evidence(3)), 4.0 / 2.0, 1e-12);
  EXPECT_EQ(outside.evidence(4), 0.0);
  EXPECT_FALSE(outside.speaks_of(4));
}

TEST(OutsideOdds, WhatMovesRatherThanRestsIsFreeFromItsBirth) {
  const OutsideOdds outside({{1, 0.49}, {2, 0.51}}, 2.0);
  for (const Births births : {Births::kHeld, Births::kStaticFirst}) {
    EXPECT_EQ(outside.births(1, births), Births::kFree);
    EXPECT_EQ(outside.births(2, births), births);
    EXPECT_EQ(outside.births(3, births), births);
  }
}

// At the defaults the answer is that of the evidence: prior odds of 2, decisive at 20 either way.
// A landmark of which any speed up to the prior's could still hide is static all the same.
TEST(Odds, OfTheDefaultsAskForEvidenceOnly) {
  const ClassifierOptions defaults;
  EXPECT_EQ(defaults.name, "odds");
  const double sigma = 1.0 / std::cbrt(10.0);
  expect_of_sigma(defaults, sigma, Label::kStatic, Label::kUnknown);
  expect_of_speed(defaults, sigma * std::sqrt(2.0 * std::log(2.0 * 20.0 * 10.0)), sigma);
  MotionBelief b = belief({0, 0, 0}, 0.01);
  b.covariance(2, 2) = 1.0;
  EXPECT_EQ(decide(defaults, b), Label::kStatic);
}

TEST(Odds, OfWhatMovedMustOutweighThatItMoved) {
  const auto classifier = make_classifier(odds(), {});
  ClassifierMemory memory;
  EXPECT_EQ(classifier->decide(belief({10, 0, 0}, 0.1), memory), Label::kMoving);
  // The belief has forgotten: odds of 1e3 suffice at first sight, not now, when 1e4 are asked.
  ClassifierMemory none;
  EXPECT_EQ(classifier->decide(belief({0, 0, 0}, 0.1), none), Label::kStatic);
  EXPECT_EQ(classifier->decide(belief({0, 0, 0}, 0.1), memory), Label::kUnknown);
  EXPECT_EQ(classifier->decide(belief({0, 0, 0}, 0.04), memory), Label::kStatic);
}

TEST(Odds, HaveNoUnit) {
  // The same scene in other units of length, and in u = rho v at rho = 0.2.
  for (const double sigma : {0.01, 0.1, 0.25, 0.35}) {  // moving, static, unknown, unknown
    MotionBelief b = belief({0.1, 0, 0}, sigma);
    const Label label = decide(odds(), b);
    for (const double unit : {0.001, 100.0}) {
      MotionBelief in_unit = b;
      in_unit.w *= unit;
      in_unit.covariance *= unit * unit;
      in_unit.prior_sigmas *= unit;
      EXPECT_EQ(decide(odds(), in_unit), label) << unit;
    }
    b.w *= 0.2;
    b.covariance *= 0.04;
    b.prior_sigmas *= 0.2;
    b.density_scale = 0.008;
    EXPECT_EQ(decide(odds(), b), label);
  }
}

TEST(Classifier, ABrokenCovarianceDecidesNothing) {
  MotionBelief b = belief({1, 0, 0}, 0.1);
  b.covariance(1, 1) = -1.0;
  EXPECT_EQ(decide(thesis(), b), Label::kUnknown);
  EXPECT_EQ(decide(ClassifierOptions{}, b), Label::kUnknown);
}

TEST(Truth, IsKnownFromBirthAndOtherwiseUnknown) {
  ClassifierOptions options;
  options.name = "truth";
  const auto truth = make_classifier(options, {{7, Label::kMoving}});
  EXPECT_EQ(truth->at_birth(7), Label::kMoving);
  EXPECT_EQ(truth->at_birth(8), Label::kUnknown);
  EXPECT_EQ(make_classifier(thesis(), {})->at_birth(7), Label::kUnknown);
}

}  // namespace
}  // namespace slammot
