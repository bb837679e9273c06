// Labels that may be taken back, on innovations whose distribution is known.
#include <gtest/gtest.h>

#include <random>

#include "estimation/labels/label_policy.h"

namespace slammot {
namespace {

LabelOptions with_rule(LabelRule rule) {
  LabelOptions options;
  options.rule = rule;
  return options;
}
LabelOptions reversible() { return with_rule(LabelRule::kReversible); }

TEST(ChiSquareTail, IsThatOfTheTables) {
  EXPECT_NEAR(log_chi_square_tail(5.991464547107979, 1), std::log(0.05),
              1e-12);  // 2 degrees of freedom
  EXPECT_NEAR(log_chi_square_tail(37.56623478662507, 10), std::log(0.01), 1e-12);  // 20
  EXPECT_NEAR(log_chi_square_tail(0.0, 10), 0.0, 1e-12);
  EXPECT_NEAR(log_chi_square_tail(1e5, 10), -5e4 + 84.6, 0.1);  // no underflow
}

// How many of `landmarks` static ones lose their label within `frames`, their NIS being `scale`
// times chi-square(2).
int taken_back(double scale, int landmarks, int frames, const LabelOptions& options) {
  std::mt19937_64 engine(1);
  std::exponential_distribution<double> half_chi_square;  // chi-square(2) is twice exponential(1)
  int count = 0;
  for (int i = 0; i < landmarks; ++i) {
    TrackRecord record = initialised(i, 0, Label::kStatic, {});
    bool rejected = false;
    for (int frame = 0; frame < frames && !rejected; ++frame) {
      note_innovation(record, scale * 2.0 * half_chi_square(engine), options);
      rejected = is_rejected(record, options);
    }
    count += rejected;
  }
  return count;
}

TEST(Reversible, RightLabelsStayAndWrongOnesGo) {
  // 10,000 landmarks for 20 frames: at most 1e-4 a frame, fewer because frames share innovations.
  EXPECT_LE(taken_back(1.0, 10000, 20, reversible()), 10000 * 20 * 1e-4);
  EXPECT_GE(taken_back(1.0, 10000, 20, reversible()), 1);
  EXPECT_GE(taken_back(5.0, 1000, 10, reversible()), 950);
  EXPECT_EQ(taken_back(100.0, 1000, 20, with_rule(LabelRule::kOneWay)), 0);
}

// What keeps pace with the camera looks like a point beyond infinity.
TEST(Reversible, NothingThatRestsHasANegativeInverseDepth) {
  TrackRecord record = initialised(1, 0, Label::kStatic, {});
  note_depth(record, {-0.04, 0.01}, reversible());
  EXPECT_FALSE(is_rejected(record, reversible()));  // far away, four sigma
  note_depth(record, {-0.06, 0.01}, with_rule(LabelRule::kOneWay));
  EXPECT_FALSE(is_rejected(record, with_rule(LabelRule::kOneWay)));
  note_depth(record, {-0.06, 0.01}, reversible());
  EXPECT_TRUE(is_rejected(record, reversible()));
  note_reverted(record);
  EXPECT_FALSE(is_rejected(record, reversible()));
  EXPECT_TRUE(record.cannot_rest);

  TrackRecord known = initialised(2, 0, Label::kStatic, {});
  known.known = true;
  note_depth(known, {-0.06, 0.01}, reversible());
  EXPECT_FALSE(is_rejected(known, reversible()));
}

TEST(Reversible, OnlyTheLatestInnovationsCount) {
  const LabelOptions options = reversible();
  TrackRecord record = initialised(1, 0, Label::kStatic, {});
  for (int i = 0; i < 1000; ++i) note_innovation(record, 2.0, options);
  for (int i = 0; i < 5; ++i) note_innovation(record, 10.0, options);
  EXPECT_TRUE(is_rejected(record, options));  // 60 over 10 frames, not 2050 over 1005
  note_reverted(record);
  EXPECT_EQ(record.label, Label::kUnknown);
  EXPECT_FALSE(record.decision_frame);
  EXPECT_FALSE(is_rejected(record, options));
}

TEST(Reversible, WhatIsKnownBeforehandStays) {
  TrackRecord record = initialised(1, 0, Label::kStatic, {});
  record.known = true;
  for (int i = 0; i < 20; ++i) note_innovation(record, 100.0, reversible());
  EXPECT_FALSE(is_rejected(record, reversible()));
}

TEST(Reversible, NoneIsLabelledBeforeItsThirdSighting) {
  TrackRecord record = initialised(1, 0, Label::kUnknown, {});
  note_accepted(record, 1);
  EXPECT_FALSE(is_asked(record, reversible()));
  note_accepted(record, 2);
  EXPECT_TRUE(is_asked(record, reversible()));
}

TEST(Reversible, AMovingLandmarkMayStop) {
  TrackRecord record = initialised(1, 0, Label::kMoving, {});
  record.observations = 3;
  EXPECT_FALSE(is_asked(record, with_rule(LabelRule::kOneWay)));
  EXPECT_TRUE(is_asked(record, reversible()));
  note_answer(record, Label::kUnknown, 3);
  EXPECT_EQ(record.label, Label::kMoving);
  note_answer(record, Label::kStatic, 4);
  EXPECT_EQ(record.label, Label::kStatic);
  EXPECT_EQ(record.decision_frame, 4);
  EXPECT_TRUE(record.was_moving);
}

// A mover of twice the velocity's sigma, near the camera, stays within two sigmas of what is
// granted.
TEST(MovedPixels, CoverAMoverAndGrowWithTheTimeSinceItWasSeen) {
  Camera camera;
  camera.fx = camera.fy = 400.0;
  LandmarkPrior prior;
  prior.inverse_depth = 0.2;
  prior.inverse_depth_sigma = 0.1;
  prior.max_speed = 2.0;
  TrackRecord record = initialised(1, 0, Label::kStatic, prior);
  const double once = moved_px(record, camera, 0.1);
  EXPECT_NEAR(once, 400.0 * 0.4 * 1.0 * 0.1, 1e-12);
  ++record.unused_frames;
  EXPECT_NEAR(moved_px(record, camera, 0.1), 2.0 * once, 1e-12);
}

}  // namespace
}  // namespace slammot
