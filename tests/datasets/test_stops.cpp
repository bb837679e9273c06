// Objects that stop: their schedules, and what the scenario `move_stop_move` promises.
#include <gtest/gtest.h>

#include <cmath>

#include "datasets/simulation/scenario.h"
#include "datasets/simulation/scene/schedule.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

constexpr double kRate = 15.0;

const Schedule kCycles{-1.3, 0.5, 2.0, 1.5};

TEST(Schedule, PaceIsTheDerivativeOfWhatIsTravelled) {
  for (const Schedule& schedule : {kCycles, Schedule{3.0, 0.5, 1e9, 1.5}}) {
    for (double t = -2.0; t < 20.0; t += 0.0137) {
      constexpr double kStep = 1e-6;
      const double there = schedule.travelled(t + kStep), here = schedule.travelled(t - kStep);
      ASSERT_NEAR((there - here) / (2.0 * kStep), schedule.pace(t), 1e-5) << t;
    }
  }
}

TEST(Schedule, StandsWhereItStoppedAndUntilItStarts) {
  EXPECT_EQ(kCycles.pace(-1.4), 0.0);
  EXPECT_EQ(kCycles.travelled(-1.4), 0.0);
  EXPECT_EQ(kCycles.pace(-0.5), 1.0);
  // The first stop lasts from 1.7 to 3.2 s, after a ramp, 2 s and a ramp.
  for (double t = 1.71; t < 3.2; t += 0.01) {
    EXPECT_EQ(kCycles.pace(t), 0.0);
    EXPECT_EQ(kCycles.travelled(t), 2.5);
  }
  EXPECT_GT(kCycles.pace(3.21), 0.0);
}

TEST(Schedule, WithoutARampSpeedJumps) {
  const Schedule schedule{0.0, 0.0, 2.0, 1.0};
  EXPECT_EQ(schedule.pace(1.9), 1.0);
  EXPECT_EQ(schedule.pace(2.1), 0.0);
  EXPECT_DOUBLE_EQ(schedule.travelled(4.0), 3.0);
}

struct Phases {
  int stops = 0;   // moved before and went on after, all of it seen
  int leaves = 0;  // stood from the first time it was seen
};

// Velocity is zero to the bit or the object moves; positions are the sum of velocities.
void check_track(const TrueLandmark& landmark, Phases& phases) {
  bool has_moved = false, stopped = false;
  auto before = landmark.by_frame.end();
  for (auto now = landmark.by_frame.begin(); now != landmark.by_frame.end(); before = now++) {
    const bool stands = now->second.velocity.norm() == 0.0;
    ASSERT_EQ(landmark.label_at(now->first), stands ? Label::kStatic : Label::kMoving);
    const bool consecutive = before != landmark.by_frame.end() && now->first == before->first + 1;
    if (!consecutive) {
      has_moved = stopped = false;
    } else {
      const Eigen::Vector3d step = now->second.position - before->second.position;
      const Eigen::Vector3d v0 = before->second.velocity, v1 = now->second.velocity;
      const bool stood = v0.norm() == 0.0;
      ASSERT_TRUE(!stood || !stands || step.norm() == 0.0);
      // At most 2 m/s and 4 m/s^2: the trapezoid is off by less than a half of a dt^2.
      ASSERT_LT((step - 0.5 * (v0 + v1) / kRate).norm(), 0.5 * 4.0 / kRate / kRate);
      ASSERT_LT((v1 - v0).norm(), 4.0 / kRate + 1e-9);
      phases.stops += stood && !stands && stopped;
      phases.leaves += stood && !stands && !has_moved;
    }
    stopped = stopped || (has_moved && stands);
    has_moved = has_moved || !stands;
  }
}

TEST(MoveStopMove, ObjectsStandStillAndGoOn) {
  Phases phases;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Sequence s = simulate("move_stop_move", {}, seed);
    for (const auto& [track, landmark] : s.landmarks) {
      EXPECT_EQ(landmark.label, track < 300 ? Label::kStatic : Label::kMoving);
      if (landmark.label == Label::kMoving) check_track(landmark, phases);
    }
  }
  EXPECT_GT(phases.stops, 30);
  EXPECT_GT(phases.leaves, 30);
}

TEST(MoveStopMove, IsTheCircleWhenNobodyStops) {
  const Sequence s = simulate("move_stop_move", {{"stopping", "0"}, {"parked", "0"}}, 2);
  EXPECT_EQ(test::numbers_of(s), test::numbers_of(simulate("circle", {}, 2)));
}

TEST(MoveStopMove, FractionsAreAsAsked) {
  const Sequence parked = simulate("move_stop_move", {{"stopping", "0"}, {"parked", "1"}}, 1);
  for (const auto& [track, landmark] : parked.landmarks) {
    bool has_moved = false;
    for (const auto& [frame, point] : landmark.by_frame) {
      const bool moves = point.velocity.norm() > 0.0;
      EXPECT_TRUE(moves || !has_moved);  // who has left never stops
      has_moved = has_moved || moves;
    }
  }
  EXPECT_THROW(simulate("move_stop_move", {{"stopping", "0.6"}, {"parked", "0.6"}}, 1),
               std::invalid_argument);
}

// Over many seeds, on each axis and every horizon: velocities stray no further than is stated.
TEST(MoveStopMove, TheAccelerationStatedCoversTheStops) {
  constexpr size_t kHorizons = 150;
  std::vector<Eigen::Array3d> squares(kHorizons, Eigen::Array3d::Zero());
  std::vector<double> counts(kHorizons, 0.0);
  double stated = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Sequence s = simulate("move_stop_move", {}, seed);
    stated = s.prior->acceleration;
    for (const auto& [track, landmark] : s.landmarks) {
      if (landmark.label == Label::kStatic) continue;
      for (const auto& [from, a] : landmark.by_frame) {
        for (size_t n = 1; n < kHorizons; ++n) {
          const TruePoint* b = landmark.at(from + static_cast<int>(n));
          if (b == nullptr) continue;
          squares[n] += (b->velocity - a.velocity).array().square();
          counts[n] += 1.0;
        }
      }
    }
  }
  double largest = 0.0;
  for (size_t n = 1; n < kHorizons; ++n) {
    const double variance = squares[n].maxCoeff() / counts[n] / static_cast<double>(n);
    largest = std::max(largest, std::sqrt(variance) * kRate);
  }
  EXPECT_NEAR(largest / stated, 1.0, 0.1);
  EXPECT_EQ(
      simulate("move_stop_move", {{"stated_object_acceleration", "0.2"}}, 1).prior->acceleration,
      0.2);
}

}  // namespace
}  // namespace slammot
