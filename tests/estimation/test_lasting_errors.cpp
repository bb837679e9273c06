// What lasts in a track is told from what is new in each frame.
#include "estimation/modules/lasting_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estimation/gate.h"

namespace slammot {
namespace {

constexpr int kTracks = 60, kFrames = 10 * LastingErrors::kSightings;

TrackRecords records_of(int tracks) {
  TrackRecords records;
  for (int t = 0; t < tracks; ++t) records[t];
  return records;
}

// Innovations of unit variance, of which `lasting` is the same in all frames of a track.
double nis_of_thirty(double lasting) {
  std::mt19937 engine(3);
  std::normal_distribution<double> normal;
  LastingErrors errors;
  for (int t = 0; t < kTracks; ++t) {
    const Eigen::Vector2d bias(std::sqrt(lasting) * normal(engine),
                               std::sqrt(lasting) * normal(engine));
    for (int k = 0; k < kFrames; ++k) {
      const Eigen::Vector2d fresh(normal(engine), normal(engine));
      errors.add(t, k % 2, 0, bias + std::sqrt(1.0 - lasting) * fresh);
    }
  }
  const LastingErrors::Ended ended = errors.take(records_of(kTracks));
  EXPECT_EQ(ended.sums, kTracks * kFrames / LastingErrors::kSightings);
  EXPECT_EQ(errors.take({}).sums, 0);  // once
  return ended.nis / ended.sums;
}

TEST(LastingErrors, TwoWhereErrorsAreNewInEachFrame) { EXPECT_NEAR(nis_of_thirty(0.0), 2.0, 0.3); }

// 2 (1 - r + L r): each frame's own NIS is 2 throughout.
TEST(LastingErrors, AddUpWhereATenthOfThemLasts) { EXPECT_NEAR(nis_of_thirty(0.1), 7.8, 1.8); }

TEST(LastingErrors, ATrackThatEndedIsForgotten) {
  LastingErrors errors;
  int born = 0;
  const auto add = [&](int times) {
    for (int k = 0; k < times; ++k) errors.add(7, 0, born, Eigen::Vector2d::Ones());
  };
  add(LastingErrors::kSightings - 1);
  errors.take({});
  add(1);
  EXPECT_EQ(errors.take(records_of(8)).sums, 0);
  add(LastingErrors::kSightings - 2);
  born = 5;  // pruned and seen anew before anybody asked
  add(1);
  EXPECT_EQ(errors.take(records_of(8)).sums, 0);
}

// By its definition: nu_i less what the others tell of it, whitened.
TEST(LastingErrors, TheGateScalesGivenAllOthers) {
  constexpr Eigen::Index kRows = 12, kRow = 6;  // of pixel 3
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(engine); };
  const Eigen::MatrixXd half = Eigen::MatrixXd::NullaryExpr(kRows, kRows, draw);
  const Eigen::VectorXd nu = 2.0 * Eigen::VectorXd::NullaryExpr(kRows, draw);
  FrameInnovation frame;
  frame.HPHt.resize(kRows, kRows);
  *frame.HPHt = half * half.transpose();
  const Eigen::MatrixXd S = half * half.transpose() + Eigen::MatrixXd::Identity(kRows, kRows);
  for (Eigen::Index i = 0; i < kRows; i += 2) {
    frame.z.push_back({static_cast<int>(i / 2), Eigen::Vector2d::Zero()});
    frame.nu.emplace_back(nu.segment<2>(i));
  }
  FrameGate gate({.probability = 1.0, .given_others = 1.0}, 1.0);
  gate.judge(frame);

  std::vector<Eigen::Index> others;
  for (Eigen::Index i = 0; i < kRows; ++i) {
    if (i != kRow && i != kRow + 1) others.push_back(i);
  }
  const std::vector<Eigen::Index> own{kRow, kRow + 1};
  const Eigen::MatrixXd gain = S(own, others) * S(others, others).inverse();
  const Eigen::Vector2d left = nu(own) - gain * nu(others);
  const Eigen::Matrix2d information = (S(own, own) - gain * S(others, own)).inverse();
  const Eigen::Matrix2d L = information.llt().matrixL();
  EXPECT_LT((gate.scaled_given_others(3) - L.transpose() * left).norm(), 1e-9);
}

}  // namespace
}  // namespace slammot
