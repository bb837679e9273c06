// The labels of the first frame's landmarks: by rule, unknown, or decided together.
#include "estimation/labels/first_frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slammot {
namespace {

class FirstFrameOf : public testing::Test {
 protected:
  FirstFrameOf() {
    options_.start = 3;
    options_.start_over = 6;
  }

  Frame frame(int index) const {
    Frame frame{index, 0.1 * index, {}};
    for (const int track : {1, 2, 3, 4}) frame.observations.push_back({track, {0.0, 0.0}});
    return frame;
  }

  // Of a landmark of the first frame, frame 10.
  void record(int track, Label label) {
    records_[track] = initialised(track, 10, label, LandmarkPrior{});
  }

  // The first frame and two more; the second and third landmark come out as given.
  bool decide(FirstFrame& first, Label second, Label third) {
    bool revised = false;
    for (int i = 0; i < 3; ++i) {
      EXPECT_FALSE(revised);
      first.begin(frame(10 + i));
      if (i == 0) {
        EXPECT_EQ(first.label(1), Label::kUnknown);
      }
      record(1, Label::kUnknown);
      record(2, second);
      record(3, third);  // the fourth has left
      revised = first.revise(records_);
    }
    return revised;
  }

  LabelOptions options_;
  TrackRecords records_;
};

TEST_F(FirstFrameOf, IsStaticByRuleOrUnknown) {
  options_.first_frame = FirstFrameLabels::kStatic;
  FirstFrame rule(options_);
  rule.begin(frame(0));
  EXPECT_EQ(rule.label(1), Label::kStatic);
  EXPECT_TRUE(rule.is_rule());
  EXPECT_TRUE(rule.frames().empty());
  EXPECT_FALSE(rule.revise({}));

  options_.first_frame = FirstFrameLabels::kUnknown;
  FirstFrame unknown(options_);
  unknown.begin(frame(0));
  EXPECT_EQ(unknown.label(1), Label::kUnknown);
  EXPECT_FALSE(unknown.is_rule());
}

TEST_F(FirstFrameOf, OddsMakeStaticWhatDoesNotLookMoving) {
  FirstFrame first(options_);
  EXPECT_TRUE(decide(first, Label::kMoving, Label::kStatic));
  EXPECT_EQ(first.label(1), Label::kStatic);
  EXPECT_EQ(first.label(2), Label::kUnknown);
  EXPECT_EQ(first.label(3), Label::kStatic);
  EXPECT_EQ(first.label(4), Label::kUnknown);
  EXPECT_EQ(first.decision_frame(10), 12);
  EXPECT_EQ(first.frames().size(), 3u);
}

// As where processing frames again has cost enough: labels are then taken back as later ones are.
TEST_F(FirstFrameOf, ClosedItTakesNothingBackItself) {
  FirstFrame first(options_);
  EXPECT_TRUE(decide(first, Label::kMoving, Label::kStatic));
  record(1, Label::kStatic);
  EXPECT_TRUE(first.holds(records_.at(1)));
  first.accuse(1);
  first.close();
  EXPECT_FALSE(first.holds(records_.at(1)));
  EXPECT_FALSE(first.revise(records_));
  EXPECT_EQ(first.label(1), Label::kStatic);
  first.begin(frame(13));
  EXPECT_TRUE(first.frames().empty());
}

TEST_F(FirstFrameOf, AllAreStaticWhereMostLookMoving) {
  FirstFrame first(options_);
  EXPECT_TRUE(decide(first, Label::kMoving, Label::kMoving));
  for (const int track : {1, 2, 3, 4}) EXPECT_EQ(first.label(track), Label::kStatic);
}

TEST_F(FirstFrameOf, DropsTheLabelThatIsAccused) {
  FirstFrame first(options_);
  decide(first, Label::kUnknown, Label::kUnknown);
  record(1, Label::kStatic);
  record(2, Label::kStatic);
  EXPECT_TRUE(first.holds(records_.at(2)));
  EXPECT_FALSE(first.revise(records_));
  first.accuse(2);
  EXPECT_TRUE(first.revise(records_));
  EXPECT_EQ(first.label(1), Label::kStatic);
  EXPECT_EQ(first.label(2), Label::kUnknown);
  EXPECT_FALSE(first.holds(records_.at(2)));  // the classifier's label, not for us to take back
  EXPECT_FALSE(first.revise(records_));
}

TEST_F(FirstFrameOf, LabelsStandAfterTheStart) {
  FirstFrame first(options_);
  decide(first, Label::kUnknown, Label::kUnknown);
  for (int i = 3; i < 6; ++i) first.begin(frame(10 + i));
  EXPECT_EQ(first.frames().size(), 6u);
  first.begin(frame(16));
  EXPECT_TRUE(first.frames().empty());
  record(2, Label::kStatic);
  EXPECT_FALSE(first.holds(records_.at(2)));
  first.accuse(2);
  EXPECT_FALSE(first.revise(records_));
}

TEST_F(FirstFrameOf, NothingIsDecidedWhereAllLabelsAreGiven) {
  FirstFrame first(options_);
  record(1, Label::kStatic);  // as given
  for (int i = 0; i < 6; ++i) {
    first.begin(frame(10 + i));
    EXPECT_FALSE(first.holds(records_.at(1)));
    EXPECT_FALSE(first.revise(records_));
  }
  EXPECT_TRUE(first.frames().empty());
}

}  // namespace
}  // namespace slammot
