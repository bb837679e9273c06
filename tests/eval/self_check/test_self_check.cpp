// A run that is lost says so without truth, and a good one says nothing.
#include "eval/run/self_check.h"

#include <gmock/gmock.h>

namespace slammot {
namespace {

using testing::HasSubstr;

constexpr int kFrames = 60;
constexpr FrameCounts kGood{
    .accepted = 20, .accepted_static = 15, .rejected = 1, .out_of_view = 1, .joint_nis = 39.0};

RunResult run_of(const FrameCounts& bad, int from) {
  RunResult run;
  for (int i = 0; i < kFrames; ++i) {
    run.frames.push_back(i);
    run.counts.push_back(i < from ? kGood : bad);
  }
  return run;
}

std::string only_reason(const RunResult& run) {
  const std::vector<RunWarning> warnings = self_check(run);
  EXPECT_EQ(warnings.size(), 1u);
  return warnings.empty() ? "" : warnings.front().reason;
}

TEST(SelfCheck, AGoodRunHasNoWarning) { EXPECT_TRUE(self_check(run_of(kGood, 0)).empty()); }

TEST(SelfCheck, AFewBadFramesAreNone) {
  FrameCounts bad = kGood;
  bad.joint_nis = 100.0;
  RunResult run = run_of(kGood, 0);
  for (std::size_t i = 30; i < 35; ++i) run.counts[i] = bad;
  EXPECT_TRUE(self_check(run).empty());
}

TEST(SelfCheck, JointNisTellsOfWrongNoise) {
  FrameCounts bad = kGood;
  bad.joint_nis = 120.0;  // 6 a measurement
  const RunResult run = run_of(bad, 40);
  EXPECT_THAT(only_reason(run), HasSubstr("joint NIS"));
  EXPECT_GE(self_check(run).front().frame, 20);  // not before the trouble is in the sum
}

// Noise that is stated three times too large makes a ninth of 2.
TEST(SelfCheck, JointNisTellsOfNoiseThatIsTooLarge) {
  FrameCounts calm = kGood;
  calm.joint_nis = 4.4;  // 0.22 a measurement
  EXPECT_TRUE(self_check(run_of(calm, 0)).empty());
  calm.joint_nis = 3.6;
  EXPECT_TRUE(self_check(run_of(calm, 40)).empty());  // part of a run
  EXPECT_THAT(only_reason(run_of(calm, 0)), HasSubstr("more than three times too large"));
}

TEST(SelfCheck, ManyRejected) {
  FrameCounts bad = kGood;
  bad.rejected = 6;  // of 27; 2 of 22 are none
  EXPECT_THAT(only_reason(run_of(bad, 20)), HasSubstr("wrong matches"));
}

// As after a jump of the camera, of the clock or of the tracks; new tracks hide it again.
TEST(SelfCheck, MostRejectedAtOnce) {
  FrameCounts bad = kGood;
  bad.accepted = bad.accepted_static = 7;
  bad.rejected = 7;
  bad.joint_nis = 14.0;
  RunResult run = run_of(kGood, 0);
  for (std::size_t i = 40; i < 45; ++i) run.counts[i] = bad;
  EXPECT_THAT(only_reason(run), HasSubstr("at once"));
  EXPECT_EQ(self_check(run).front().frame, 40);
}

TEST(SelfCheck, WhatIsNotStatedIsNoReason) {
  FrameCounts unstated = kGood;
  unstated.joint_nis = kUndefined;
  EXPECT_TRUE(self_check(run_of(unstated, 0)).empty());
  EXPECT_TRUE(self_check(run_of({.joint_nis = kUndefined}, 0)).empty());
}

TEST(SelfCheck, AllOnOneLine) {
  RunResult run = run_of(kGood, 0);
  run.ray_spread.assign(kFrames, 40.0);
  for (std::size_t i = 30; i < 45; ++i) run.ray_spread[i] = 1.0;
  EXPECT_TRUE(self_check(run).empty());  // half of 30
  run.ray_spread[50] = 1.0;
  EXPECT_THAT(only_reason(run), HasSubstr("in 16 of 30 frames the static landmarks in view lie"));
}

TEST(SelfCheck, AGapInTime) {
  RunResult run = run_of(kGood, 0);
  double time = 0.0;
  for (std::size_t i = 0; i < kFrames; ++i) {
    time += i == 20 ? 0.3 : i == 40 ? 5.0 : 0.1;  // a few frames lost are none
    run.filtered.emplace_back().timestamp = time;
    run.filtered.back().covariance.setConstant(kUndefined);
  }
  const std::vector<RunWarning> warnings = self_check(run);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings.front().frame, 40);
  EXPECT_THAT(warnings.front().reason, HasSubstr("no frame for 5 s"));
}

TEST(SelfCheck, NothingUsed) {
  EXPECT_THAT(only_reason(run_of(FrameCounts{}, 25)), HasSubstr("no measurement was used"));
}

TEST(SelfCheck, FewStaticInView) {
  FrameCounts bad = kGood;
  bad.accepted_static = 4;
  EXPECT_THAT(only_reason(run_of(bad, 20)), HasSubstr("static landmarks in view in 16 of 30"));
}

TEST(SelfCheck, NothingStaticInView) {
  FrameCounts bad = kGood;
  bad.accepted_static = 0;
  RunResult run = run_of(kGood, 0);
  run.counts[30] = bad;
  EXPECT_THAT(only_reason(run), HasSubstr("none is static"));
  EXPECT_EQ(self_check(run).front().frame, 30);
}

// Before labels are found, and through frames that measure nothing.
TEST(SelfCheck, NothingStaticYetOrNothingAtAllIsNoReason) {
  FrameCounts not_yet = kGood;
  not_yet.accepted_static = 0;
  RunResult run = run_of(kGood, 0);
  for (std::size_t i = 0; i < 5; ++i) run.counts[i] = not_yet;
  run.counts[40] = FrameCounts{};
  EXPECT_TRUE(self_check(run).empty());
}

// Where the camera turns into a part of the scene that is full of movers.
TEST(SelfCheck, FewStaticInMostFrames) {
  FrameCounts bad = kGood;
  bad.accepted_static = 3;
  RunResult run = run_of(kGood, 0);
  for (std::size_t i = 20; i < 50; i += 2) run.counts[i] = bad;
  EXPECT_TRUE(self_check(run).empty());  // half
  run.counts[35] = bad;
  EXPECT_THAT(only_reason(run), HasSubstr("static landmarks in view"));
}

TEST(SelfCheck, HardlyAnythingUsedIsStatic) {
  FrameCounts bad = kGood;
  bad.accepted = 60;
  bad.accepted_static = 5;
  bad.joint_nis = 118.0;
  EXPECT_THAT(only_reason(run_of(bad, 20)), HasSubstr("used in 30 frames are of static landmarks"));
}

// A scene half of whose points move, as `circle` is, is none that is lost.
TEST(SelfCheck, ManyMoversAreNoReason) {
  FrameCounts half = kGood;
  half.accepted_static = 5;
  EXPECT_TRUE(self_check(run_of(half, 0)).empty());
}

RunResult with_labels(int resting, int moving, int unknown) {
  RunResult run = run_of(kGood, 0);
  const auto add = [&](Label label, int count) {
    for (int i = 0; i < count; ++i) {
      LandmarkRecord& landmark = run.landmarks.emplace_back();
      landmark.estimate.track = static_cast<int>(run.landmarks.size());
      landmark.estimate.label = label;
    }
  };
  add(Label::kStatic, resting);
  add(Label::kMoving, moving);
  add(Label::kUnknown, unknown);
  return run;
}

TEST(SelfCheck, LabelsHaveCollapsed) {
  EXPECT_TRUE(self_check(with_labels(10, 20, 0)).empty());  // two in three
  EXPECT_EQ(only_reason(with_labels(9, 21, 100)),
            "of the 30 landmarks called static or moving, over the whole run, 21 are called "
            "moving: unless most do move, the labels have collapsed");
}

TEST(SelfCheck, LabelsThatNobodyDecidedSayNothingOfTheOthers) {
  RunResult run = with_labels(50, 21, 0);
  EXPECT_TRUE(self_check(run).empty());
  for (std::size_t i = 0; i < 41; ++i) run.landmarks[i].estimate.by_rule = true;
  EXPECT_THAT(only_reason(run), HasSubstr("21 are called moving"));
}

TEST(SelfCheck, AFewLabelsSayNothing) {
  EXPECT_TRUE(self_check(with_labels(0, 19, 100)).empty());
  EXPECT_FALSE(self_check(with_labels(0, 20, 0)).empty());
}

TEST(SelfCheck, RotationDisagrees) {
  const RotationSpan good{.first = 0, .last = 10, .five_point = 40, .estimate = 33, .angle = 0.02};
  std::vector<RotationSpan> spans(20, good);
  const RunResult run = run_of(kGood, 0);
  EXPECT_TRUE(self_check(run, spans).empty());
  for (std::size_t i : {4u, 9u, 12u, 17u}) {  // one in five is still allowed
    spans[i] = {.first = static_cast<int>(i), .last = 20, .five_point = 40, .estimate = 31};
  }
  EXPECT_TRUE(self_check(run, spans).empty());
  spans[7] = {.first = 7, .last = 20, .five_point = 40, .estimate = 10, .angle = 0.1};
  const std::vector<RunWarning> warnings = self_check(run, spans);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].frame, 4);
  EXPECT_THAT(warnings[0].reason, HasSubstr("rotation disagrees with a five-point estimate"));
  EXPECT_THAT(warnings[0].reason, HasSubstr("5 of 20"));
}

RunResult first_frames_of(RunResult run, std::size_t frames) {
  run.frames.resize(frames);
  run.counts.resize(frames);
  return run;
}

TEST(SelfCheck, ARunTooShortToJudgeIsNotJudged) {
  EXPECT_TRUE(self_check(first_frames_of(run_of(FrameCounts{}, 0), 9)).empty());
}

// Ten to thirty frames are one sum.
TEST(SelfCheck, AShortRunIsJudgedAsAWhole) {
  const auto reason = [](const FrameCounts& bad, std::size_t frames) {
    return only_reason(first_frames_of(run_of(bad, 0), frames));
  };
  EXPECT_TRUE(self_check(first_frames_of(run_of(kGood, 0), 10)).empty());
  EXPECT_THAT(reason(FrameCounts{}, 10), HasSubstr("no measurement was used for 10 frames"));
  FrameCounts bad = kGood;
  bad.joint_nis = 120.0;
  EXPECT_THAT(reason(bad, 10), HasSubstr("over 10 frames: the stated noise is too small"));
  bad = kGood;
  bad.rejected = 6;
  EXPECT_THAT(reason(bad, 20), HasSubstr("20 frames were rejected"));
  bad = kGood;
  bad.accepted_static = 0;
  EXPECT_THAT(reason(bad, 29), HasSubstr("static landmarks in view in 29 of 29 frames"));
  RunResult line = first_frames_of(run_of(kGood, 0), 12);
  line.ray_spread.assign(12, 1.0);
  EXPECT_THAT(only_reason(line), HasSubstr("in 12 of 12 frames"));
}

// The first may be a pin, and one that is not stated is no reason.
TEST(SelfCheck, ACovarianceThatIsNotPositiveDefinite) {
  RunResult run = run_of(kGood, 0);
  run.filtered.resize(kFrames);
  for (CameraEstimate& camera : run.filtered) camera.covariance.setIdentity();
  run.filtered[0].covariance.setZero();
  run.filtered[20].covariance.setConstant(kUndefined);
  EXPECT_TRUE(self_check(run).empty());
  run.filtered[30].covariance.block<3, 3>(kPosition, kRotation).setConstant(kUndefined);
  run.filtered[30].covariance(kRotation, kRotation) = -1.0;
  run.filtered[40].covariance(kPosition, kPosition) = -1.0;
  EXPECT_THAT(only_reason(run), HasSubstr("2 of 58"));
  EXPECT_EQ(self_check(run).front().frame, 30);
}

}  // namespace
}  // namespace slammot
