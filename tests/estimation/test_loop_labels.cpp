// What the frame loop makes of labels: given, and undone. The belief is told what to say.
#include <gmock/gmock.h>

#include "tests/estimation/frame_loop_fixture.h"

namespace slammot {
namespace {

using test::FakeBelief;
using testing::ElementsAre;
using testing::IsEmpty;

class LoopLabels : public test::FrameLoopOf {};

TEST_F(LoopLabels, ClassifiesAndCollapses) {
  ModelOptions models;
  models.classifier.name = "thesis";
  start(models);
  frame({});
  EXPECT_EQ(frame({1, 2, 3}).admitted, 3);  // after the first frame: unknown
  belief_->state.at(1) = {true, 0.0, 0.0, 0.1};
  belief_->state.at(2) = {true, 0.0, 5.0, 0.1};
  belief_->state.at(3) = {true, 0.0, 1.0, 2.0};
  frame({1, 2, 3});
  EXPECT_EQ(label(1), Label::kStatic);
  EXPECT_EQ(label(2), Label::kMoving);
  EXPECT_EQ(label(3), Label::kUnknown);
  EXPECT_FALSE(belief_->state.at(1).is_free);
  EXPECT_TRUE(belief_->state.at(2).is_free);
}

// It keeps pace with the camera: released once, and never static again, however well it rests.
TEST_F(LoopLabels, WhatIsBeyondInfinityIsNotStatic) {
  ModelOptions models;
  models.classifier.name = "thesis";
  start(models);
  frame({});
  frame({1, 2});
  for (const int track : {1, 2}) belief_->state.at(track) = {true, 0.0, 0.0, 0.1};
  frame({1, 2});
  ASSERT_EQ(label(1), Label::kStatic);
  belief_->state.at(1).inverse_depth = -0.004;  // four sigma
  frame({1, 2});
  EXPECT_EQ(label(1), Label::kStatic);
  belief_->state.at(1).inverse_depth = -0.006;
  frame({1, 2});
  EXPECT_EQ(label(1), Label::kUnknown);
  EXPECT_TRUE(belief_->state.at(1).is_free);
  belief_->state.at(1).inverse_depth = 0.5;
  for (int k = 0; k < 5; ++k) frame({1, 2});
  EXPECT_EQ(label(1), Label::kUnknown);
  EXPECT_EQ(label(2), Label::kStatic);
}

// What no motion explains is a wrong match; what one explains speaks against the label.
TEST_F(LoopLabels, AWrongMatchSaysNothingOfALabel) {
  start({});
  frame({1, 2});
  for (const double error : {300.0, -500.0, 0.0, 400.0, 0.0}) {
    belief_->state.at(1).error = error;
    EXPECT_EQ(frame({1, 2}).rejected, error == 0.0 ? 0 : 1);
    EXPECT_EQ(label(1), Label::kStatic) << error;
  }
  belief_->state.at(1).error = 10.0;
  frame({1, 2});
  EXPECT_EQ(label(1), Label::kUnknown);
}

TEST_F(LoopLabels, RevertsAStaticLabelThatTheOtherMeasurementsReject) {
  start({});
  frame({1, 2});
  belief_->state.at(1).leave_one_out = 30.0;
  frame({1, 2});
  EXPECT_EQ(label(1), Label::kStatic);  // a single outlier is the gate's business
  frame({1, 2});
  EXPECT_EQ(label(1), Label::kUnknown);
  EXPECT_EQ(label(2), Label::kStatic);
  EXPECT_TRUE(belief_->state.at(1).is_free);

  ModelOptions one_way;
  one_way.labels.rule = LabelRule::kOneWay;
  start(one_way);
  index_ = 0;
  frame({1});
  belief_->state.at(1).leave_one_out = 30.0;
  for (int i = 0; i < 5; ++i) frame({1});
  EXPECT_EQ(label(1), Label::kStatic);
  EXPECT_EQ(count("leave_one_out"), 0);
}

// Of those that are remembered the surest of a frame; the others are free from now on.
TEST_F(LoopLabels, UndoesWhatIsRememberedOfARejectedLabel) {
  start({});
  frame({1, 2, 3, 4});
  belief_->remembered = {1, 2, 3};
  for (const int track : {1, 2, 4}) belief_->state.at(track).leave_one_out = 30.0;
  frame({1, 2, 3, 4});
  frame({1, 2, 3, 4});
  EXPECT_EQ(count("release"), 1);
  EXPECT_EQ(count("free"), 1);
  EXPECT_EQ(label(1), Label::kStatic);
  EXPECT_EQ(label(2), Label::kUnknown);
  EXPECT_EQ(label(3), Label::kStatic);  // not rejected
  EXPECT_EQ(label(4), Label::kUnknown);
  frame({1, 2, 3, 4});
  EXPECT_EQ(label(1), Label::kUnknown);
}

// A motion that is remembered from birth; then for so long, while it is seen, and in doubt
// (test_label_revision.cpp).
TEST_F(LoopLabels, ForgetsMotions) {
  remembers_all_ = true;
  ModelOptions models;
  models.classifier.name = "thesis";
  models.labels.memory = 8;
  start_with(models);
  frame({1, 2, 3});
  belief_->state.at(2).held_sigma = 1e-4;
  frame({1, 2, 3});
  EXPECT_THAT(belief_->remembered, ElementsAre(1, 2, 3));
  frame({1, 2});
  EXPECT_THAT(calls_, ElementsAre("forget", "predict", "innovations", "update", "leave_one_out",
                                  "inverse_depths", "motions", "finish"));
  EXPECT_THAT(belief_->remembered, ElementsAre(1, 3));
  for (int i = 0; i < 5; ++i) frame({1, 2});
  EXPECT_THAT(belief_->remembered, ElementsAre(1));  // the other was not seen five times
  for (int i = 0; i < 2; ++i) frame({1, 2});
  EXPECT_THAT(belief_->remembered, IsEmpty());
  EXPECT_EQ(label(1), Label::kStatic);
}

// What its motion would be says sooner than innovations that a label is wrong.
TEST_F(LoopLabels, StartsOverWithoutTheSurestMoverOfTheFirstFrame) {
  remembers_all_ = true;
  ModelOptions models;
  models.classifier.name = "thesis";
  start_with(models);
  frame({10, 20, 60, 70});  // of these the fake believes 1, 2, 6 and 7 m/s, each +- 1
  EXPECT_EQ(label(70), Label::kStatic);
  EXPECT_EQ(belief_->remembered, (std::set{10, 20, 60, 70}));
  frame({10, 20, 60, 70});
  EXPECT_EQ(label(70), Label::kUnknown);
  EXPECT_EQ(label(60), Label::kUnknown);  // one at a time, and all frames again after each
  EXPECT_EQ(label(20), Label::kStatic);
  EXPECT_EQ(count("predict"), 1 + 2 * 2);
  EXPECT_EQ(count("release"), 0);
}

// Of labels of the first frame, where nothing is remembered; all frames so far are processed again
// without it.
TEST_F(LoopLabels, StartsOverWithoutTheMostRejected) {
  start_with({});
  frame({1, 2, 3});
  EXPECT_FALSE(loop_->records().at(1).by_rule);
  belief_->state.at(1).leave_one_out = 20.0;
  belief_->state.at(2).leave_one_out = 30.0;
  frame({1, 2, 3});
  EXPECT_EQ(label(2), Label::kStatic);
  const FakeBelief* before = belief_;
  EXPECT_EQ(frame({1, 2, 3, 4}).admitted, 1);  // of the newest frame
  EXPECT_NE(belief_, before);
  EXPECT_EQ(count("predict"), 1 + 3);
  EXPECT_NEAR(belief_->last_dt, 0.1, 1e-15);
  EXPECT_EQ(label(1), Label::kStatic);
  EXPECT_EQ(label(2), Label::kUnknown);
  EXPECT_EQ(label(3), Label::kStatic);
  EXPECT_EQ(count("free"), 0);
  // One label, counted once, however many frames were processed again.
  for (const Mechanism& m : loop_->in_force()) {
    if (m.name == "labels undone" || m.name == "first frame's labels undone from the start") {
      EXPECT_TRUE(m.is_on) << m.name;
      EXPECT_EQ(m.acted, 1) << m.name;
    }
    if (m.key == "gate.given_others") {
      EXPECT_EQ(m.acted, 0) << m.name;
    }
  }
}

}  // namespace
}  // namespace slammot
