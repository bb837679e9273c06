// Alignment and trajectory errors on trajectories whose errors are known by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "eval/metrics/accuracy.h"
#include "eval/metrics/alignment.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

std::vector<Eigen::Vector3d> random_points(int count) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    points.push_back(Eigen::Vector3d::NullaryExpr([&] { return normal(random); }));
  }
  return points;
}

TEST(Alignment, RecoversAKnownSimilarity) {
  Similarity truth;
  truth.scale = 2.5;
  truth.rotation = exp_so3(Eigen::Vector3d(0.4, -2.0, 1.0)).toRotationMatrix();
  truth.translation << 5, -6, 7;
  const auto estimate = random_points(20);
  std::vector<Eigen::Vector3d> target;
  for (const auto& p : estimate) target.push_back(truth * p);
  const Similarity found = align(estimate, target, AlignmentGroup::kSim3);
  EXPECT_NEAR(found.scale, truth.scale, 1e-12);
  EXPECT_LT((found.rotation - truth.rotation).norm(), 1e-12);
  EXPECT_LT((found.translation - truth.translation).norm(), 1e-12);
  EXPECT_LT(absolute_trajectory_error(estimate, target, found), 1e-12);
  const Similarity rigid = align(estimate, target, AlignmentGroup::kSE3);
  EXPECT_NEAR(rigid.scale, 1.0, 1e-12);
  EXPECT_GT(absolute_trajectory_error(estimate, target, rigid), 0.1);
}

TEST(Alignment, FewOrEqualPointsGiveATranslation) {
  const std::vector<Eigen::Vector3d> zeros(5, Eigen::Vector3d::Zero());
  const std::vector<Eigen::Vector3d> ones(5, Eigen::Vector3d::Ones());
  const Similarity found = align(zeros, ones, AlignmentGroup::kSim3);
  EXPECT_EQ(found.scale, 1.0);
  EXPECT_EQ(found.translation, Eigen::Vector3d::Ones());
  EXPECT_TRUE(std::isnan(absolute_trajectory_error({}, {}, found)));
}

std::vector<PosePair> pairs_of(const Sequence& sequence,
                               const std::function<void(int, CameraState&)>& disturb) {
  std::vector<CameraEstimate> estimates;
  for (size_t i = 0; i < sequence.frames.size(); ++i) {
    CameraEstimate estimate;
    estimate.timestamp = sequence.frames[i].timestamp;
    estimate.state = *sequence.truth[i];
    disturb(static_cast<int>(i), estimate.state);
    estimates.push_back(estimate);
  }
  return pair_with_truth(sequence, estimates);
}

TEST(Accuracy, ByHand) {
  // Off by 0, 1, 2 m along y: RMSE sqrt(5/3), and 1 m of drift in each second.
  const Sequence sequence = test::straight_line(3);
  const Accuracy a = accuracy(pairs_of(sequence, [](int i, CameraState& x) {
    x.position.y() += i;
    x.orientation = exp_so3(Eigen::Vector3d(0, 0, 0.1 * i));
  }));
  EXPECT_EQ(a.poses, 3);
  EXPECT_NEAR(a.position_rmse, std::sqrt(5.0 / 3.0), 1e-12);
  EXPECT_NEAR(a.position_max, 2.0, 1e-12);
  EXPECT_NEAR(a.position_final, 2.0, 1e-12);
  const double degrees = 180.0 / std::numbers::pi;
  EXPECT_NEAR(a.rotation_rmse_deg, 0.1 * std::sqrt(5.0 / 3.0) * degrees, 1e-9);
  EXPECT_NEAR(a.rotation_max_deg, 0.2 * degrees, 1e-9);
  EXPECT_EQ(a.relative_pairs, 2);
  EXPECT_NEAR(a.relative_rotation_rmse_deg, 0.1 * degrees, 1e-9);
  // (0,0,0) to (2,2,0) is a line: rotating by 45 degrees leaves lengths 2 and 2 sqrt 2.
  EXPECT_NEAR(a.scale, 1.0 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(a.ate_sim3, 0.0, 1e-7);
  EXPECT_NEAR(a.ate_se3, (std::sqrt(2.0) - 1.0) * std::sqrt(2.0 / 3.0), 1e-12);
}

TEST(Accuracy, FailedAboveATenthOfThePath) {
  const Sequence sequence = test::straight_line(41);  // a metre in each frame
  const auto off_by = [&](double metres, int from) {
    return pairs_of(sequence, [=](int i, CameraState& x) {
      if (i >= from) x.position.y() += metres;
    });
  };
  EXPECT_EQ(failed_at(off_by(1.1, 0), false), 1);  // above a metre
  EXPECT_EQ(failed_at(off_by(0.9, 0), false), std::nullopt);
  EXPECT_EQ(failed_at(off_by(2.05, 20), false), 20);  // of 20 m
  EXPECT_EQ(failed_at(off_by(2.05, 21), false), std::nullopt);
  EXPECT_EQ(failed_at({}, false), std::nullopt);
  const Sequence brief = test::straight_line(6);
  const auto pairs = pairs_of(brief, [](int, CameraState& x) { x.position.y() += 0.6; });
  EXPECT_EQ(failed_at(pairs, false), 1);            // above a tenth of the whole 5 m
  EXPECT_EQ(failed_at(pairs, true), std::nullopt);  // aligned away
}

TEST(Accuracy, ACameraAtRestFailsAboveAMetre) {
  const Sequence sequence = test::straight_line(600);
  auto pairs = pairs_of(sequence, [](int, CameraState&) {});
  for (PosePair& pair : pairs) {
    pair.truth.position = Eigen::Vector3d(pair.frame % 2 == 0 ? 0.0 : 1e-4, 0.0, 0.0);  // jitter
    pair.estimate.state.position = Eigen::Vector3d(0.0, 0.9, 0.0);
  }
  EXPECT_EQ(failed_at(pairs, false), std::nullopt);
  pairs.back().estimate.state.position.y() = 1.1;
  EXPECT_EQ(failed_at(pairs, false), pairs.back().frame);
}

// A long path in a small room: a similarity makes a point of an estimate that follows nothing of
// it, and its error is then no tenth of the path.
TEST(Accuracy, AnEstimateThatFollowsNothingFailsAfterAlignment) {
  auto pairs = pairs_of(test::straight_line(600), [](int, CameraState&) {});
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (PosePair& pair : pairs) {
    const double t = 0.1 * pair.frame;
    pair.truth.position = {std::sin(t), std::sin(1.7 * t), 0.2 * std::sin(2.3 * t)};
    pair.estimate.state.position = pair.truth.position + Eigen::Vector3d(0.05, 0.0, 0.0);
  }
  EXPECT_EQ(failed_at(pairs, true), std::nullopt);
  for (PosePair& pair : pairs) {
    pair.estimate.state.position = Eigen::Vector3d::NullaryExpr([&] { return normal(random); });
  }
  EXPECT_LT(accuracy(pairs).ate_sim3, 0.1 * 60.0);
  EXPECT_TRUE(failed_at(pairs, true));
}

TEST(PosePairs, AFrameHasItsNearestEstimateOnly) {
  const Sequence sequence = test::straight_line(3);
  std::vector<CameraEstimate> dense;
  for (const double time : {0.6, 0.9, 1.2, 1.45}) {
    dense.emplace_back();
    dense.back().timestamp = time;
  }
  const auto pairs = pair_with_truth(sequence, dense);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].frame, 1);
  EXPECT_EQ(pairs[0].estimate.timestamp, 0.9);
}

TEST(Accuracy, RelativeErrorIgnoresARigidOffset) {
  const Sequence sequence = test::straight_line(5);
  const Eigen::Quaterniond turn = exp_so3(Eigen::Vector3d(0.2, 0.3, -0.4));
  const Accuracy a = accuracy(pairs_of(sequence, [&](int, CameraState& x) {
    x.position = turn * x.position + Eigen::Vector3d(1, 2, 3);
    x.orientation = turn * x.orientation;
  }));
  EXPECT_GT(a.position_rmse, 1.0);
  EXPECT_NEAR(a.relative_position_rmse, 0.0, 1e-12);
  EXPECT_NEAR(a.relative_rotation_rmse_deg, 0.0, 1e-6);
  EXPECT_NEAR(a.ate_se3, 0.0, 1e-7);
}

TEST(PosePairs, NearestWithinHalfAFrame) {
  const Sequence sequence = test::straight_line(3);
  CameraEstimate near, far;
  near.timestamp = 1.4;
  far.timestamp = 2.7;
  const auto pairs = pair_with_truth(sequence, {near, far});
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].frame, 1);
}

}  // namespace
}  // namespace slammot
