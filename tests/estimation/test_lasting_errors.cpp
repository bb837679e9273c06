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
      errors.add(t, k % 2, bias + std::sqrt(1.0 - lasting) * fresh);
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
  const auto add = [&](int times) {
    for (int k = 0; k < times; ++k) errors.add(7, 0, Eigen::Vector2d::Ones());
  };
  add(LastingErrors::kSightings - 1);
  errors.take({});
  add(1);
  EXPECT_EQ(errors.take(records_of(8)).sums, 0);
}

// Of pixels that share the camera's error, as drawn from what the gate is told.
TEST(LastingErrors, TheGateScalesGivenAllOthers) {
  constexpr int kPixels = 8, kDraws = 2000;
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  FrameInnovation frame;
  frame.HPHt.resize(2 * kPixels, 2 * kPixels);
  (*frame.HPHt).setConstant(25.0);
  (*frame.HPHt).diagonal().array() += 1.0;
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int draw = 0; draw < kDraws; ++draw) {
    const double shared = 5.0 * normal(engine);
    frame.z.clear();
    frame.nu.clear();
    for (int i = 0; i < kPixels; ++i) {
      frame.z.push_back({i, Eigen::Vector2d::Zero()});
      const double u = shared + std::sqrt(2.0) * normal(engine);
      frame.nu.emplace_back(u, shared + std::sqrt(2.0) * normal(engine));
    }
    FrameGate gate({.probability = 1.0, .given_others = 1.0}, 1.0);
    gate.judge(frame);
    sum += gate.scaled_given_others(3) * gate.scaled_given_others(3).transpose();
  }
  EXPECT_LT((sum / kDraws - Eigen::Matrix2d::Identity()).norm(), 0.12);
}

}  // namespace
}  // namespace slammot
