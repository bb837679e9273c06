// Truth at its own times, and what of a sequence is hardly meant.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/sequence/sequence_hints.h"
#include "tests/datasets/fixture.h"

namespace slammot {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kStep = 0.1, kTurn = 0.2;  // [s], [rad/s]

// Turns about z on a circle of 1 m.
CameraState on_circle(double t) {
  CameraState state;
  state.position = {std::cos(kTurn * t), std::sin(kTurn * t), 0.0};
  state.orientation = Eigen::AngleAxisd(kTurn * t, Eigen::Vector3d::UnitZ());
  return state;
}

std::vector<TimedPose> poses_at(const std::vector<double>& times) {
  std::vector<TimedPose> poses;
  for (const double t : times) {
    const CameraState x = on_circle(t);
    poses.push_back({t, x.position, x.orientation, static_cast<int>(poses.size()) + 1});
  }
  return poses;
}

std::vector<double> times(int count, double step, double first = 0.0) {
  std::vector<double> all;
  for (int i = 0; i < count; ++i) all.push_back(first + i * step);
  return all;
}

Sequence sequence_of(int frames) {
  Sequence s;
  for (int i = 0; i < frames; ++i) s.frames.push_back({i, i * kStep, {}, {}});
  return s;
}

Sequence with_truth(int frames, const std::vector<TimedPose>& poses) {
  Sequence s = sequence_of(frames);
  s.truth = true_cameras(poses, s.frames);
  return s;
}

int known(const Sequence& s) {
  return static_cast<int>(std::ranges::count_if(s.truth, [](const auto& x) { return !!x; }));
}

TEST(TruePoses, AtTheTimesOfTheFramesAreTakenToTheLastDigit) {
  const std::vector<TimedPose> poses = poses_at(times(20, kStep));
  const Sequence s = with_truth(20, poses);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(s.truth[i]->position, poses[i].position);
    EXPECT_EQ(s.truth[i]->orientation.coeffs(), poses[i].orientation.coeffs());
  }
}

TEST(TruePoses, AreInterpolatedBetweenThoseAroundAFrame) {
  for (const auto& at : {times(60, 0.04), times(20, kStep, 0.02), times(20, kStep, -0.05)}) {
    const Sequence s = with_truth(20, poses_at(at));
    EXPECT_GE(known(s), 19);  // none before the first
    for (std::size_t i = 0; i < s.truth.size(); ++i) {
      if (!s.truth[i]) continue;
      const CameraState x = on_circle(s.frames[i].timestamp);
      EXPECT_LT((s.truth[i]->position - x.position).norm(), kTurn * kTurn * kStep * kStep / 8);
      EXPECT_LT(s.truth[i]->orientation.angularDistance(x.orientation), 1e-9);
    }
  }
}

TEST(TruePoses, AreNotInterpolatedOverGapsNorTakenFromAfar) {
  EXPECT_EQ(known(with_truth(60, poses_at(times(6, 1.0)))), 6);
  EXPECT_EQ(known(with_truth(60, poses_at(times(6, 1.0, 0.02)))), 0);
  EXPECT_EQ(known(with_truth(60, poses_at(times(6, 1.0, 0.0004)))), 6);  // rounded times
  std::vector<double> with_hole = times(20, kStep);
  for (const double t : times(20, kStep, 4.0)) with_hole.push_back(t);
  EXPECT_EQ(known(with_truth(60, poses_at(with_hole))), 40);
}

Hints hints_of(const std::vector<TimedPose>& poses, int frames = 40) {
  return truth_hints("groundtruth.tum", poses, with_truth(frames, poses));
}

TEST(TruthHints, NothingIsSaidOfACompleteTruth) {
  EXPECT_THAT(hints_of(poses_at(times(40, kStep))), IsEmpty());
  EXPECT_THAT(hints_of(poses_at(times(400, 0.01))), IsEmpty());
  auto rests_and_goes = poses_at(times(40, kStep));
  for (std::size_t i = 0; i < 30; ++i) rests_and_goes[i].position.setZero();
  for (std::size_t i = 30; i < 40; ++i) {
    const double t = kStep * static_cast<double>(i - 30);
    rests_and_goes[i].position = {t * t, 0.0, 0.0};
  }
  EXPECT_THAT(hints_of(rests_and_goes), IsEmpty());
}

TEST(TruthHints, FewTruePosesAreCounted) {
  EXPECT_THAT(hints_of(poses_at(times(6, 1.0)), 60),
              ElementsAre(HasSubstr("truth for 6 of 60 frames")));
  auto milliseconds = poses_at(times(40, kStep));
  for (TimedPose& pose : milliseconds) pose.timestamp *= 1000.0;
  EXPECT_THAT(hints_of(milliseconds), ElementsAre(HasSubstr("are these milliseconds")));
}

TEST(TruthHints, ARowThatJumpsAwayAndBackIsNamed) {
  for (const std::size_t row : {0u, 1u, 17u, 38u, 39u}) {
    for (const double size : {0.5, 58.0}) {
      auto poses = poses_at(times(40, kStep));
      poses[row].position.y() += size;
      EXPECT_THAT(
          hints_of(poses),
          ElementsAre(HasSubstr("groundtruth.tum:" + std::to_string(row + 1) + ": the true")))
          << row << ' ' << size;
    }
  }
  auto two = poses_at(times(40, kStep));
  two[20].position.x() += 5.0;
  two[21].position.x() += 5.0;
  EXPECT_THAT(hints_of(two), ElementsAre(HasSubstr("groundtruth.tum:21: 2 true poses are")));
  auto flipped = poses_at(times(40, kStep));
  flipped[8].orientation = flipped[8].orientation * Eigen::Quaterniond(0, 1, 0, 0);
  EXPECT_THAT(hints_of(flipped), ElementsAre(HasSubstr("groundtruth.tum:9: the true pose is 1")));
}

TEST(TruthHints, ARowBeyondAnySpeedIsRefused) {
  auto poses = poses_at(times(40, kStep));
  poses[0].position.x() = 883e3;
  EXPECT_THAT(test::refusal_of([&] { hints_of(poses); }), HasSubstr("groundtruth.tum:1: the true"));
}

// Five tracks that move a pixel in each frame, but not in frames 4 and 5.
Sequence frozen() {
  Sequence s = sequence_of(10);
  for (Frame& frame : s.frames) {
    const double u = frame.index == 4 || frame.index == 5 ? 3.0 : frame.index;
    for (int track = 0; track < 5; ++track)
      frame.observations.push_back({track, {u, 10.0 * track}});
  }
  return s;
}

TEST(FrameHints, FramesThatRepeatTheOneBeforeAreNamed) {
  Sequence s = frozen();
  EXPECT_THAT(frame_hints(s), ElementsAre(HasSubstr("frames 4 to 5 measure exactly what frame 3")));
  s.frames[4].observations[0].pixel.x() += 1e-12;  // a difference in the last digits is none
  EXPECT_THAT(frame_hints(s), IsEmpty());
  s.frames.resize(3);
  for (Frame& frame : s.frames) frame.observations = s.frames[0].observations;
  EXPECT_THAT(frame_hints(s), IsEmpty());  // nothing ever moves
  s = frozen();
  s.truth.assign(10, on_circle(0.0));  // truly at rest, without noise
  EXPECT_THAT(frame_hints(s), IsEmpty());
}

TEST(FrameHints, AStepThatNoCameraHasIsTakenForAnotherUnit) {
  for (const auto& [factor, unit] :
       {std::pair(1e3, "milliseconds"), {1e6, "microseconds"}, {1e9, "nanoseconds"}}) {
    Sequence s = sequence_of(10);
    for (Frame& frame : s.frames) frame.timestamp *= factor;
    EXPECT_THAT(frame_hints(s), ElementsAre(HasSubstr(unit)));
  }
}

TEST(FrameHints, AFirstCameraFarFromTheTrueOneIsNamed) {
  Sequence s = with_truth(4, poses_at(times(4, kStep)));
  s.exact_truth = true;
  s.initial = InitialCamera{};
  s.initial->state = *s.truth.front();
  s.initial->rotation_sigma = s.initial->position_sigma = 1e-3;
  EXPECT_THAT(frame_hints(s), IsEmpty());
  s.initial->state.orientation = Eigen::Quaterniond(0, 1, 0, 0);
  s.initial->state.position.z() += 3.0;
  EXPECT_THAT(frame_hints(s),
              ElementsAre(HasSubstr("180 deg from the first true one, stated to 0.001 rad"),
                          HasSubstr("3 m from the first true one")));
}

TEST(LensReach, MeasurementsWithoutARayAreLeftOutAndCounted) {
  Sequence s = sequence_of(2);
  s.camera = {640, 480, 385.0, 385.0, 319.5, 239.5, RadtanLens{{-0.35, 0, 0, 0, 0}}};
  const auto at = [&](double r) { return Eigen::Vector2d(319.5 + r, 239.5); };
  s.frames[0].observations = {{1, at(250.0)}, {2, at(251.0)}, {3, at(350.0)}};
  s.frames[1].observations = {{1, at(100.0)}};
  const auto hint = leave_out_rayless(s);
  ASSERT_TRUE(hint);
  EXPECT_THAT(*hint, HasSubstr("2 measurements in 1 frames are left out"));
  EXPECT_THAT(*hint, HasSubstr("250.5 px"));
  EXPECT_EQ(s.frames[0].observations.size(), 1u);
  EXPECT_FALSE(leave_out_rayless(s));
  s.camera.lens = PinholeLens{};
  s.frames[0].observations = {{3, at(350.0)}};
  EXPECT_FALSE(leave_out_rayless(s));
}

}  // namespace
}  // namespace slammot
