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

// Those that are remembered as if they had never rested; the others are free from now on.
TEST_F(LoopLabels, UndoesWhatIsRememberedOfARejectedLabel) {
  start({});
  frame({1, 2, 3, 4});
  belief_->remembered = {1, 2, 3};
  for (const int track : {1, 2, 4}) belief_->state.at(track).leave_one_out = 30.0;
  frame({1, 2, 3, 4});
  frame({1, 2, 3, 4});
  EXPECT_EQ(count("release"), 2);
  EXPECT_EQ(count("free"), 1);
  EXPECT_EQ(label(3), Label::kStatic);  // not rejected
  for (const int track : {1, 2, 4}) EXPECT_EQ(label(track), Label::kUnknown);
}

// A motion that is remembered from birth; then for so long, while it is seen, and in doubt
// (test_label_revision.cpp).
TEST_F(LoopLabels, ForgetsMotions) {
  remembers_all_ = true;
  ModelOptions models;
  models.classifier.name = "thesis";
  models.labels.memory = 8;
  setup_.prior.max_speed = 20.0;
  start_with(models);
  frame({1, 2, 3});
  for (const int track : {1, 3}) belief_->state.at(track).held_sigma = 0.3;
  belief_->state.at(2).held_sigma = 1e-4;
  for (int i = 0; i < 2; ++i) frame({1, 2, 3});
  for (const int track : {1, 2, 3}) EXPECT_EQ(label(track), Label::kStatic);
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

class HeldBirths : public LoopLabels {
 protected:
  HeldBirths() {
    remembers_all_ = true;
    models_.classifier.name = "thesis";
    setup_.prior.max_speed = 20.0;
  }
  bool is_held(int track) const { return loop_->records().at(track).is_held; }
  ModelOptions models_;
};

// Of these the fake believes 1, 2, 6 and 7 m/s, each +- 1: also of the first frame none is static
// by rule, and all rest until their second sighting. 1 +- 1 m/s speaks for rest where movers have
// 10 m/s.
TEST_F(HeldBirths, RestUntilTheirMotionSaysOtherwise) {
  start_with(models_);
  frame({10, 20, 60, 70});
  for (const int track : {10, 20, 60, 70}) {
    EXPECT_EQ(label(track), Label::kUnknown);
    EXPECT_TRUE(is_held(track));
    EXPECT_FALSE(belief_->state.at(track).is_free);
  }
  EXPECT_FALSE(loop_->records().at(10).by_rule);
  frame({10, 20, 60, 70});
  EXPECT_EQ(count("release"), 2);
  for (const int track : {60, 70}) {
    EXPECT_TRUE(belief_->state.at(track).is_free);
    EXPECT_FALSE(is_held(track));
  }
  for (const int track : {10, 20}) EXPECT_TRUE(is_held(track));
  std::map<std::string, long> acted;
  for (const auto& row : loop_->in_force()) acted[row.name] = row.acted;
  EXPECT_EQ(acted.at("births held at rest"), 4);
  EXPECT_EQ(acted.at("births that were held released"), 2);
  EXPECT_EQ(acted.at("labels undone"), 0);  // they had none
}

// 3 m/s +- 1 speaks neither for rest nor clearly against it: enough, with odds of rest of 99. What
// moves rather than rests is never held.
TEST_F(HeldBirths, FollowOddsFromOutside) {
  models_.classifier.name = "odds";
  setup_.p_static = {{30, 0.99}, {41, 0.01}};
  start_with(models_);
  frame({10, 30, 31, 41});
  EXPECT_TRUE(belief_->state.at(41).is_free);
  for (const int track : {10, 30, 31}) EXPECT_TRUE(is_held(track));
  frame({10, 30, 31, 41});
  EXPECT_TRUE(is_held(30));
  EXPECT_FALSE(is_held(31));
  frame({10, 30, 31, 41});
  EXPECT_EQ(label(30), Label::kStatic);
  const InForce rows = loop_->in_force();
  const auto row = std::ranges::find(rows, "priors.csv", &Mechanism::key);
  ASSERT_NE(row, rows.end());
  EXPECT_TRUE(row->is_on);
  EXPECT_EQ(row->acted, 2);
}

// It has no prior odds; the run says so.
TEST_F(HeldBirths, OfTheThesissClassifierTakeNoOdds) {
  setup_.p_static = {{41, 0.01}};
  start_with(models_);
  frame({41});
  EXPECT_TRUE(is_held(41));
  const InForce rows = loop_->in_force();
  const auto row = std::ranges::find(rows, "priors.csv", &Mechanism::key);
  EXPECT_FALSE(row->is_on);
  EXPECT_EQ(row->because, "classifier=thesis");
  setup_.p_static.clear();
  start_with(models_);
  EXPECT_EQ(std::ranges::count(loop_->in_force(), "priors.csv", &Mechanism::key), 0);
}

TEST_F(HeldBirths, AreStaticOnceTheirMotionSaysSo) {
  start_with(models_);
  frame({1, 10});
  belief_->state.at(1).held_sigma = 0.01;
  frame({1, 10});
  EXPECT_EQ(frame({1, 10}).accepted_static, 2);
  EXPECT_EQ(label(1), Label::kStatic);
  EXPECT_EQ(loop_->records().at(1).decision_frame, 2);
  EXPECT_FALSE(is_held(1));
  EXPECT_EQ(label(10), Label::kUnknown);
  EXPECT_EQ(count("collapse"), 0);  // at rest it was all the time
  // Out of sight the open one is given up as any unknown one is, the static one is not.
  for (int k = 0; k < 7; ++k) frame({2});
  EXPECT_TRUE(loop_->records().contains(1));
  EXPECT_FALSE(loop_->records().contains(10));
}

TEST_F(HeldBirths, AreStaticFirstWhereNoMotionIsRemembered) {
  models_.labels.memory = 0;
  start_with(models_);
  frame({1});
  frame({1, 2});
  EXPECT_EQ(label(1), Label::kStatic);
  EXPECT_TRUE(loop_->records().at(1).by_rule);
  EXPECT_EQ(label(2), Label::kUnknown);
  EXPECT_TRUE(belief_->state.at(2).is_free);
}

}  // namespace
}  // namespace slammot
