// Alignment and trajectory errors on trajectories whose errors are known by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "eval/metrics/accuracy.h"
#include "eval/metrics/alignment.h"
#include "tests/eval/fixture.h"

namespace slammot {
namespace {

// That a similarity is found again is a law (test_laws.cpp).
TEST(Alignment, OfARigidGroupHasNoScale) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> estimate, target;
  for (int i = 0; i < 20; ++i) {
    estimate.push_back(Eigen::Vector3d::NullaryExpr([&] { return normal(random); }));
    target.push_back(2.5 * estimate.back());
  }
  EXPECT_NEAR(align(estimate, target, AlignmentGroup::kSim3).scale, 2.5, 1e-12);
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
  EXPECT_EQ(failed_at(off_by(1.1, 0), false), 0);  // above a metre
  EXPECT_EQ(failed_at(off_by(0.9, 0), false), std::nullopt);
  EXPECT_EQ(failed_at(off_by(2.05, 20), false), 20);  // of 20 m
  EXPECT_EQ(failed_at(off_by(2.05, 21), false), std::nullopt);
  EXPECT_EQ(failed_at({}, false), std::nullopt);
  const Sequence brief = test::straight_line(6);
  const auto pairs = pairs_of(brief, [](int, CameraState& x) { x.position.y() += 0.6; });
  EXPECT_EQ(failed_at(pairs, false), 0);            // above a tenth of the whole 5 m
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

// A tenth of a path of two centimetres is jitter, not failure.
TEST(Accuracy, LessThanADecimetreIsNoFailure) {
  auto pairs = pairs_of(test::straight_line(21), [](int, CameraState&) {});
  for (PosePair& pair : pairs) {
    pair.truth.position = {1e-3 * pair.frame, 0.0, 0.0};
    pair.estimate.state.position = {0.0, 0.09, 0.0};
  }
  EXPECT_EQ(failed_at(pairs, false), std::nullopt);
  EXPECT_EQ(failed_at(pairs, true), std::nullopt);
  pairs[7].estimate.state.position.y() = 0.11;
  EXPECT_EQ(failed_at(pairs, false), 7);
}

TEST(Accuracy, NoScaleAlignsWhatDoesNotMove) {
  for (const double jitter : {0.0, 1e-15}) {
    const Accuracy still = accuracy(pairs_of(test::straight_line(9), [=](int i, CameraState& x) {
      x.position = {jitter * i, 0.0, 0.0};
    }));
    EXPECT_TRUE(std::isnan(still.ate_sim3) && std::isnan(still.scale));
    EXPECT_EQ(still.sim3_reason, "the estimate does not move");
    EXPECT_NEAR(still.ate_se3, std::sqrt(60.0 / 9.0), 1e-9);
  }
  auto pairs = pairs_of(test::straight_line(9), [](int, CameraState&) {});
  for (PosePair& pair : pairs) pair.truth.position = {1e-4 * (pair.frame % 2), 0.0, 0.0};
  const Accuracy still = accuracy(pairs);
  EXPECT_TRUE(std::isnan(still.ate_sim3) && std::isnan(still.scale));
  EXPECT_EQ(still.sim3_reason, "the true camera does not move");
  EXPECT_TRUE(failed_at(pairs, true));  // no similarity makes a point of its path
  // A small copy of the path does have a scale.
  const Accuracy small = accuracy(pairs_of(
      test::straight_line(9), [](int, CameraState& x) { x.position = 1e-4 * x.position; }));
  EXPECT_NEAR(small.scale, 1e4, 1e-6);
  EXPECT_NEAR(small.relative_scaled_rmse, 0.0, 1e-9);
  EXPECT_NEAR(small.relative_position_rmse, 1.0, 1e-3);
}

TEST(Accuracy, OverDistancesAndAlongThePath) {
  // Ten per cent too short in its first half, of a path of 1000 m, and then right.
  const Accuracy a = accuracy(pairs_of(test::straight_line(1001), [](int i, CameraState& x) {
    x.position.x() = i < 500 ? 0.9 * i : i - 50.0;
  }));
  EXPECT_NEAR(a.scale_along_path.front(), 0.9, 1e-9);
  EXPECT_NEAR(a.scale_along_path.back(), 1.0, 1e-9);
  EXPECT_GT(a.over_kitti.stretches, 300);
  EXPECT_NEAR(a.over_kitti.rotation_deg_per_m, 0.0, 1e-12);
  // A stretch of 100 m ends at the first pose beyond, at 101 m: 10% of 101 m where it is short.
  const double hundred[] = {100.0};
  const auto pairs =
      pairs_of(test::straight_line(300), [](int, CameraState& x) { x.position *= 0.9; });
  const DistanceErrors short_by_a_tenth = distance_errors(pairs, hundred, kKittiStep, 1.0 / 0.9);
  EXPECT_NEAR(short_by_a_tenth.translation_percent, 10.1, 1e-9);
  EXPECT_NEAR(short_by_a_tenth.scaled_percent, 0.0, 1e-9);
  EXPECT_EQ(short_by_a_tenth.stretches, 20);
  EXPECT_TRUE(std::isnan(accuracy(pairs_of(test::straight_line(9), [](int, CameraState&) {
                         })).over_kitti.translation_percent));
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

TEST(PosePairs, AFrameHasItsNearestEstimateWithinHalfAFrameOnly) {
  const auto judged = [](const std::vector<double>& times) {
    std::vector<CameraEstimate> estimates;
    for (const double time : times) estimates.emplace_back().timestamp = time;
    std::vector<std::pair<int, double>> found;
    for (const PosePair& pair : pair_with_truth(test::straight_line(3), estimates)) {
      found.emplace_back(pair.frame, pair.estimate.timestamp);
    }
    return found;
  };
  const std::pair near_enough{1, 1.4}, nearest{1, 0.9};
  EXPECT_THAT(judged({1.4, 2.7}), testing::ElementsAre(near_enough));
  EXPECT_THAT(judged({0.6, 0.9, 1.2, 1.45}), testing::ElementsAre(nearest));
}

}  // namespace
}  // namespace slammot
