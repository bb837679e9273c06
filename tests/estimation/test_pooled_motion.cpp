// Neighbouring tracks that move alike decide together (pooled_motion.h).
#include <gtest/gtest.h>

#include "estimation/labels/pooled_motion.h"

namespace slammot {
namespace {

constexpr double kRadius = 30.0;  // [px]

MotionBelief belief(int track, const Eigen::Vector3d& w, double sigma) {
  MotionBelief b;
  b.track = track;
  b.w = w;
  b.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  b.prior_sigmas = MotionVector::Ones(3);
  return b;
}

Label decide(const MotionBelief& b) {
  ClassifierMemory memory;
  return make_classifier({}, {})->decide(b, memory);
}

std::vector<Observation> row(int tracks, double step) {
  std::vector<Observation> z;
  for (int i = 0; i < tracks; ++i) z.push_back({i, {step * i, 0.0}});
  return z;
}

// Linear measurements of one w, split between two tracks, are those of one track.
TEST(PoolMotions, IsWhatOneTrackWouldHaveLearntFromAllMeasurements) {
  const Eigen::Vector3d sigmas(1.0, 2.0, 0.5);
  const Eigen::Matrix3d prior = sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
  Eigen::Matrix3d H1, H2;
  H1 << 3, 1, 0, 0, 2, 1, 1, 0, 4;
  H2 << 1, 0, 2, 0, 5, 0, 1, 1, 1;
  const Eigen::Vector3d z1(0.3, 0.1, -0.2), z2(0.1, 0.4, 0.2);
  std::vector<MotionBelief> motions(2);
  const auto learn = [&](MotionBelief& b, const Eigen::Matrix3d& information,
                         const Eigen::Vector3d& vector) {
    b.covariance = information.inverse();
    b.w = b.covariance * vector;
    b.prior_sigmas = sigmas;
  };
  learn(motions[0], prior + H1.transpose() * H1, H1.transpose() * z1);
  learn(motions[1], prior + H2.transpose() * H2, H2.transpose() * z2);
  motions[1].track = 1;
  MotionBelief both;
  learn(both, prior + H1.transpose() * H1 + H2.transpose() * H2,
        H1.transpose() * z1 + H2.transpose() * z2);
  pool_motions(row(2, 10.0), kRadius, motions);
  for (const MotionBelief& motion : motions) {
    EXPECT_LT((motion.w - both.w).norm(), 1e-12);
    EXPECT_LT((motion.covariance - both.covariance).norm(), 1e-12);
  }
}

// One point of an object is 2.3 sigma from rest, four of them 4.8.
TEST(PoolMotions, AnObjectIsFoundBeforeItsPoints) {
  std::vector<MotionBelief> motions;
  for (int i = 0; i < 4; ++i) motions.push_back(belief(i, {0.7, 0.0, 0.0}, 0.3));
  for (const MotionBelief& motion : motions) EXPECT_EQ(decide(motion), Label::kUnknown);
  pool_motions(row(4, 5.0), kRadius, motions);
  for (const MotionBelief& motion : motions) EXPECT_EQ(decide(motion), Label::kMoving);
}

TEST(PoolMotions, NeitherFarNorUnlikeTracksCount) {
  const std::vector<MotionBelief> alone = {belief(0, {0.6, 0, 0}, 0.1), belief(1, {0, 0, 0}, 0.1)};
  const auto unchanged = [&](const std::vector<MotionBelief>& motions) {
    for (std::size_t i = 0; i < alone.size(); ++i) {
      EXPECT_LT((motions[i].w - alone[i].w).norm(), 1e-12);
      EXPECT_LT((motions[i].covariance - alone[i].covariance).norm(), 1e-12);
    }
  };
  std::vector<MotionBelief> unlike = alone;  // 4.2 sigma apart
  pool_motions(row(2, 5.0), kRadius, unlike);
  unchanged(unlike);
  std::vector<MotionBelief> alike = alone;
  alike[1].w = alike[0].w;
  std::vector<MotionBelief> far = alike;
  pool_motions(row(2, 1.001 * kRadius), kRadius, far);
  EXPECT_LT((far[1].covariance - alike[1].covariance).norm(), 1e-12);
  pool_motions(row(2, 0.999 * kRadius), kRadius, alike);
  EXPECT_LT(alike[1].covariance(0, 0), 0.6 * alone[1].covariance(0, 0));
}

TEST(PoolMotions, DoesNotDependOnTheOrder) {
  std::vector<MotionBelief> motions;
  for (int i = 0; i < 5; ++i) motions.push_back(belief(i, {0.1 * i, 0.05, 0.0}, 0.1 + 0.05 * i));
  std::vector<MotionBelief> reversed(motions.rbegin(), motions.rend());
  pool_motions(row(5, 12.0), kRadius, motions);
  pool_motions(row(5, 12.0), kRadius, reversed);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_LT((motions[i].w - reversed[4 - i].w).norm(), 1e-12);
  }
}

// What process noise has widened beyond the prior takes away from the others: no longer a Gaussian.
TEST(PoolMotions, WhatWouldHaveNoCovarianceStaysAlone) {
  std::vector<MotionBelief> motions = {belief(0, {0, 0, 0}, 1.2), belief(1, {0, 0, 0}, 5.0)};
  for (int i = 2; i < 6; ++i) motions.push_back(belief(i, {0, 0, 0}, 5.0));
  pool_motions(row(6, 1.0), kRadius, motions);
  EXPECT_NEAR(motions[0].covariance(0, 0), 1.44, 1e-12);
}

TEST(PoolMotions, ABrokenCovarianceIsLeftOut) {
  std::vector<MotionBelief> motions = {belief(0, {0.6, 0, 0}, 0.1), belief(1, {0.6, 0, 0}, 0.1)};
  motions[1].covariance(1, 1) = -1.0;
  pool_motions(row(2, 5.0), kRadius, motions);
  EXPECT_NEAR(motions[0].covariance(0, 0), 0.01, 1e-12);
  EXPECT_EQ(motions[1].covariance(1, 1), -1.0);
}

}  // namespace
}  // namespace slammot
