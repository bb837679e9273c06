// The labels of the first frame's landmarks: by rule, unknown, or static until one is undone.
#include "estimation/modules/first_frame.h"

#include <gtest/gtest.h>

namespace slammot {
namespace {

constexpr int kFirst = 10;  // Frame::index of the first

Frame frame(int index) { return {index, 0.1 * index, {{1, {0.0, 0.0}}}}; }

TrackRecord record(int track, Label label, int first_frame = kFirst) {
  return initialised(track, first_frame, label, LandmarkPrior{});
}

// After its beginning.
FirstFrame with(FirstFrameLabels labels) {
  LabelOptions options;
  options.first_frame = labels;
  options.start_over = 3;
  FirstFrame first(options);
  first.begin(frame(kFirst));
  return first;
}

TEST(FirstFrame, IsStaticByRuleOrUnknown) {
  FirstFrame rule = with(FirstFrameLabels::kStatic), unknown = with(FirstFrameLabels::kUnknown);
  for (const FirstFrame* first : {&rule, &unknown}) {
    EXPECT_FALSE(first->is_open());
    EXPECT_TRUE(first->frames().empty());
  }
  EXPECT_EQ(rule.label(1), Label::kStatic);
  EXPECT_TRUE(rule.is_rule());
  EXPECT_FALSE(rule.undoes_from_the_start(record(1, Label::kStatic)));
  EXPECT_EQ(unknown.label(1), Label::kUnknown);
  EXPECT_FALSE(unknown.is_rule());
}

TEST(FirstFrame, OfOddsIsStaticAtOnceButForWhatIsDropped) {
  FirstFrame first = with(FirstFrameLabels::kOdds);
  EXPECT_FALSE(first.is_rule());
  for (const int track : {1, 2}) {
    EXPECT_EQ(first.label(track), Label::kStatic);
    EXPECT_TRUE(first.undoes_from_the_start(record(track, Label::kStatic)));
  }
  first.drop(2);
  EXPECT_EQ(first.label(1), Label::kStatic);
  EXPECT_EQ(first.label(2), Label::kUnknown);
  EXPECT_TRUE(first.undoes_from_the_start(record(1, Label::kStatic)));
  EXPECT_FALSE(first.undoes_from_the_start(
      record(2, Label::kStatic)));  // the classifier's label from now on
}

TEST(FirstFrame, HoldsStaticLandmarksOfThatFrameThatWereNotKnown) {
  FirstFrame first = with(FirstFrameLabels::kOdds);
  first.label(1);
  EXPECT_FALSE(first.undoes_from_the_start(record(1, Label::kUnknown)));
  EXPECT_FALSE(first.undoes_from_the_start(record(1, Label::kMoving)));
  EXPECT_FALSE(first.undoes_from_the_start(record(1, Label::kStatic, kFirst + 1)));
  TrackRecord known = record(1, Label::kStatic);
  known.known = true;
  EXPECT_FALSE(first.undoes_from_the_start(known));
}

TEST(FirstFrame, LabelsStandAfterTheStart) {
  FirstFrame first = with(FirstFrameLabels::kOdds);
  for (int i = 0; i < 3; ++i) {
    if (i > 0) first.begin(frame(kFirst + i));
    first.label(1);
    ASSERT_EQ(std::ssize(first.frames()), i + 1);
    EXPECT_EQ(first.frames().back().index, kFirst + i);
    EXPECT_TRUE(first.undoes_from_the_start(record(1, Label::kStatic)));
  }
  first.begin(frame(kFirst + 3));
  EXPECT_FALSE(first.is_open());
  EXPECT_TRUE(first.frames().empty());
  EXPECT_FALSE(first.undoes_from_the_start(record(1, Label::kStatic)));
}

// As where processing frames again has cost enough.
TEST(FirstFrame, ClosedItHoldsNothing) {
  FirstFrame first = with(FirstFrameLabels::kOdds);
  EXPECT_EQ(first.label(1), Label::kStatic);
  first.close();
  EXPECT_FALSE(first.undoes_from_the_start(record(1, Label::kStatic)));
  first.begin(frame(kFirst + 1));
  EXPECT_TRUE(first.frames().empty());
}

// The classifier gave all labels, so that none was asked for.
TEST(FirstFrame, IsClosedWhereAllLabelsAreGiven) {
  FirstFrame first = with(FirstFrameLabels::kOdds);
  EXPECT_FALSE(first.undoes_from_the_start(record(1, Label::kStatic)));
  EXPECT_TRUE(first.is_open());
  first.begin(frame(kFirst + 1));
  EXPECT_FALSE(first.is_open());
}

}  // namespace
}  // namespace slammot
