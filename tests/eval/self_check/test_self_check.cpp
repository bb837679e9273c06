// A run that is lost says so without truth, and a good one says nothing.
#include "eval/run/self_check.h"

#include <gmock/gmock.h>

namespace slammot {
namespace {

using testing::HasSubstr;

constexpr int kFrames = 60;
constexpr FrameCounts kGood{
    .accepted = 20, .accepted_static = 15, .rejected = 1, .out_of_view = 1, .joint_nis = 39.0};

FrameCounts with(void (*change)(FrameCounts&)) {
  FrameCounts counts = kGood;
  change(counts);
  return counts;
}

// A run of good frames, of which those in [from, to) are others.
RunResult run_of(const FrameCounts& bad, int from, int to = kFrames) {
  RunResult run;
  for (int i = 0; i < kFrames; ++i) {
    run.frames.push_back(i);
    run.counts.push_back(from <= i && i < to ? bad : kGood);
  }
  return run;
}

std::string only_reason(const RunResult& run) {
  const std::vector<RunWarning> warnings = self_check(run);
  EXPECT_EQ(warnings.size(), 1u);
  return warnings.empty() ? "" : warnings.front().reason;
}

const FrameCounts kNoisy = with([](FrameCounts& c) { c.joint_nis = 120.0; });  // 6 a measurement
// Noise that is stated three times too large makes a ninth of 2; this is 0.18.
const FrameCounts kCalm = with([](FrameCounts& c) { c.joint_nis = 3.6; });
const FrameCounts kRejected =
    with([](FrameCounts& c) { c.rejected = 6; });  // of 27; 2 of 22 are none
const FrameCounts kMoving = with([](FrameCounts& c) { c.accepted_static = 0; });

struct Case {
  const char* law;
  FrameCounts counts;
  int from, to;
  const char* reason;  // null: none
};

const Case kCases[] = {
    {"a good run", kGood, 0, kFrames, nullptr},
    {"a few bad frames", with([](FrameCounts& c) { c.joint_nis = 100.0; }), 30, 35, nullptr},
    {"the joint NIS tells of wrong noise", kNoisy, 40, kFrames, "joint NIS"},
    {"nearly three times too large", with([](FrameCounts& c) { c.joint_nis = 4.4; }), 0, kFrames,
     nullptr},
    {"noise that is too large in part of a run", kCalm, 40, kFrames, nullptr},
    {"noise that is too large", kCalm, 0, kFrames, "more than three times too large"},
    {"errors that are independent",
     with([](FrameCounts& c) { c.lasting_sums = 2, c.lasting_nis = 7.8; }), 0, kFrames, nullptr},
    {"errors that last", with([](FrameCounts& c) { c.lasting_sums = 2, c.lasting_nis = 8.2; }), 0,
     kFrames, "errors last from frame to frame"},
    {"too few to say", with([](FrameCounts& c) { c.lasting_sums = 2, c.lasting_nis = 90.0; }), 0,
     14, nullptr},
    {"many rejected", kRejected, 20, kFrames, "wrong matches"},
    {"what is not stated", with([](FrameCounts& c) { c.joint_nis = kUndefined; }), 0, kFrames,
     nullptr},
    {"nothing but what is not stated", {.joint_nis = kUndefined}, 0, kFrames, nullptr},
    {"nothing used", {}, 25, kFrames, "no measurement was used"},
    {"few static in view", with([](FrameCounts& c) { c.accepted_static = 4; }), 20, kFrames,
     "static landmarks in view in 16 of 30"},
    {"nothing static in view", kMoving, 30, 31, "none is static"},
    {"nothing static yet, before labels are found", kMoving, 0, 5, nullptr},
    {"a frame that measures nothing", {}, 40, 41, nullptr},
    {"many movers, as half of the points of `circle`",
     with([](FrameCounts& c) { c.accepted_static = 5; }), 0, kFrames, nullptr},
    {"hardly anything used is static",
     {.accepted = 60, .accepted_static = 5, .rejected = 1, .out_of_view = 1, .joint_nis = 118.0},
     20,
     kFrames,
     "used in 30 frames are of static landmarks"},
};

TEST(SelfCheck, OfTheCountsOfEachFrame) {
  for (const Case& c : kCases) {
    SCOPED_TRACE(c.law);
    const RunResult run = run_of(c.counts, c.from, c.to);
    if (c.reason) {
      EXPECT_THAT(only_reason(run), HasSubstr(c.reason));
    } else {
      EXPECT_TRUE(self_check(run).empty());
    }
  }
  EXPECT_EQ(self_check(run_of(kMoving, 30, 31)).front().frame, 30);
  EXPECT_GE(self_check(run_of(kNoisy, 40)).front().frame, 20);  // once the trouble is in the sum
}

// As after a jump of the camera, of the clock or of the tracks; new tracks hide it again.
TEST(SelfCheck, MostRejectedAtOnce) {
  const FrameCounts bad{
      .accepted = 7, .accepted_static = 7, .rejected = 7, .out_of_view = 1, .joint_nis = 14.0};
  const RunResult run = run_of(bad, 40, 45);
  EXPECT_THAT(only_reason(run), HasSubstr("at once"));
  EXPECT_EQ(self_check(run).front().frame, 40);
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

// Where the camera turns into a part of the scene that is full of movers.
TEST(SelfCheck, FewStaticInMostFrames) {
  const FrameCounts bad = with([](FrameCounts& c) { c.accepted_static = 3; });
  RunResult run = run_of(kGood, 0);
  for (std::size_t i = 20; i < 50; i += 2) run.counts[i] = bad;
  EXPECT_TRUE(self_check(run).empty());  // half
  run.counts[35] = bad;
  EXPECT_THAT(only_reason(run), HasSubstr("static landmarks in view"));
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

// Labels that nobody decided say nothing of the others, and few say nothing at all.
TEST(SelfCheck, OnlyManyDecidedLabelsTell) {
  RunResult run = with_labels(50, 21, 0);
  EXPECT_TRUE(self_check(run).empty());
  for (std::size_t i = 0; i < 41; ++i) run.landmarks[i].estimate.by_rule = true;
  EXPECT_THAT(only_reason(run), HasSubstr("21 are called moving"));
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

// Ten to thirty frames are one sum.
TEST(SelfCheck, AShortRunIsJudgedAsAWholeAndAShorterOneIsNot) {
  const auto reason = [](const FrameCounts& bad, std::size_t frames) {
    return only_reason(first_frames_of(run_of(bad, 0), frames));
  };
  EXPECT_TRUE(self_check(first_frames_of(run_of({}, 0), 9)).empty());
  EXPECT_TRUE(self_check(first_frames_of(run_of(kGood, 0), 10)).empty());
  EXPECT_THAT(reason({}, 10), HasSubstr("no measurement was used for 10 frames"));
  EXPECT_THAT(reason(kNoisy, 10), HasSubstr("over 10 frames: the stated noise is too small"));
  EXPECT_THAT(reason(kRejected, 20), HasSubstr("20 frames were rejected"));
  EXPECT_THAT(reason(kMoving, 29), HasSubstr("static landmarks in view in 29 of 29 frames"));
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
