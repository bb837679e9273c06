// The frame loop, driven with a belief that is told what to say: what it asks, in which order, and
// what it makes of the answers.
#include <gmock/gmock.h>

#include <numeric>

#include "tests/estimation/frame_loop_fixture.h"

namespace slammot {
namespace {

using test::FakeBelief;
using testing::ElementsAre;
using testing::IsEmpty;

class FrameLoopOf : public test::FrameLoopOf {};

TEST_F(FrameLoopOf, AsksInTheOrderOfTheThesis) {
  setup_.known = {{7, {0.0, 0.0, 2.0}, 0.01}};
  start({});
  frame({1, 7});
  EXPECT_THAT(calls_, ElementsAre("predict", "add_known", "innovations", "update", "leave_one_out",
                                  "inverse_depths", "motions", "add", "finish"));
  EXPECT_EQ(belief_->last_dt, 0.0);
  frame({1, 2, 7});
  EXPECT_NEAR(belief_->last_dt, 0.1, 1e-15);
  frame({1, 2, 7});
  EXPECT_THAT(belief_->asked, ElementsAre(2));  // of the first frame's no label is open
  Frame again{index_, 0.1 * (index_ - 1), {}};
  EXPECT_THROW(loop_->process(again, stages_), std::invalid_argument);
}

// The noise of a step is wider after a curve.
TEST_F(FrameLoopOf, WidensTheCamerasNoiseInACurve) {
  setup_.camera_noise.acceleration = 0.5;
  for (const bool adaptive : {true, false}) {
    index_ = 0;
    ModelOptions models;
    models.adaptive_motion = adaptive;
    start(models);
    belief_->acceleration = {5.0, 0.0, 0.0};
    for (int k = 0; k < 10; ++k) frame({1});
    if (adaptive) {
      EXPECT_GT(belief_->last_noise.acceleration, 2.0);
    } else {
      EXPECT_EQ(belief_->last_noise.acceleration, 0.5);
    }
    EXPECT_EQ(belief_->last_noise.angular_acceleration, setup_.camera_noise.angular_acceleration);
  }
}

// Static landmarks that are all off by the same six pixels: the camera was jolted, its step is
// widened, and the gate is asked again. Not where that is switched off, where too few of them are
// seen, nor where a landmark has just entered at this camera.
TEST_F(FrameLoopOf, AJoltWidensItsOwnStep) {
  const auto widened = [this](std::vector<int> tracks, bool adaptive, bool enters) {
    index_ = 0;
    setup_.known.clear();
    if (enters) setup_.known.push_back({9, {0.0, 0.0, 2.0}, 0.01});
    ModelOptions models;
    models.adaptive_motion = adaptive;
    start(models);
    frame(tracks);
    belief_->shared = 1.0;
    for (auto& [track, landmark] : belief_->state) landmark.error = 6.0;
    if (enters) tracks.push_back(9);
    frame(tracks);
    return std::ranges::count(calls_, "widen");
  };
  EXPECT_EQ(widened({1, 2, 3, 4, 5}, true, false), 1);
  EXPECT_DOUBLE_EQ(belief_->shared, 36.0 / (1.0 + 1.0) / 2.0);
  EXPECT_EQ(std::ranges::count(calls_, "innovations"), 2);
  frame({1, 2, 3, 4, 5});
  EXPECT_GT(belief_->last_noise.acceleration, setup_.camera_noise.acceleration);
  EXPECT_EQ(widened({1, 2, 3, 4, 5}, false, false), 0);
  EXPECT_EQ(widened({1, 2, 3, 4}, true, false), 0);
  EXPECT_EQ(widened({1, 2, 3, 4, 5}, true, true), 0);
}

// Two of five that are off are wrong matches or labels.
TEST_F(FrameLoopOf, WhatAFewMeasureIsNoJolt) {
  start({});
  frame({1, 2, 3, 4, 5});
  belief_->shared = 1.0;
  belief_->state.at(1).error = belief_->state.at(4).error = 50.0;
  frame({1, 2, 3, 4, 5});
  EXPECT_EQ(std::ranges::count(calls_, "widen"), 0);
}

// No motion of the camera makes most of them agree, or five of them: their matches are wrong. The
// step stays as it was, and nothing is learnt from it.
TEST_F(FrameLoopOf, WrongMatchesAreNoJolt) {
  const auto expect_none = [this](int right, int wrong) {
    index_ = 0;
    start({});
    std::vector<int> tracks(static_cast<std::size_t>(right + wrong));
    std::iota(tracks.begin(), tracks.end(), 1);
    frame(tracks);
    belief_->shared = 1.0;
    for (const int track : tracks) {
      if (track > right) belief_->state.at(track).error = 40.0 * (track - right);
    }
    frame(tracks);
    EXPECT_EQ(std::ranges::count(calls_, "widen"), 2);
    EXPECT_NEAR(belief_->shared, 1.0, 1e-12);
    tracks.resize(static_cast<std::size_t>(right));
    EXPECT_EQ(belief_->used, tracks);
    frame(tracks);
    EXPECT_EQ(belief_->last_noise.acceleration, setup_.camera_noise.acceleration);
  };
  expect_none(5, 6);
  expect_none(3, 4);
}

// Four of five: most, but too few to tell of the camera.
TEST_F(FrameLoopOf, FourThatAgreeTeachNothing) {
  start({});
  frame({1, 2, 3, 4, 5});
  belief_->shared = 1.0;
  for (int track = 1; track <= 4; ++track) belief_->state.at(track).error = 3.4;
  belief_->state.at(5).error = 100.0;
  frame({1, 2, 3, 4, 5});
  EXPECT_EQ(std::ranges::count(calls_, "widen"), 0);
  frame({1, 2, 3, 4, 5});
  EXPECT_EQ(belief_->last_noise.acceleration, setup_.camera_noise.acceleration);
}

// Among twelve that rest, and among eleven.
TEST_F(FrameLoopOf, TellsWhomTheCameraDoesNotFollow) {
  std::vector<int> rest(12);
  std::iota(rest.begin(), rest.end(), 1);
  constexpr int kMover = 20;
  for (const int track : rest) setup_.true_labels[track] = Label::kStatic;
  setup_.true_labels[kMover] = Label::kMoving;
  for (const Movers movers : {Movers::kConsidered, Movers::kJoint}) {
    index_ = 0;
    ModelOptions models;
    models.classifier.name = "truth";
    models.policy.movers = movers;
    start_with(models);
    std::vector<int> tracks = rest;
    tracks.push_back(kMover);
    frame(tracks);
    frame(tracks);
    const bool considers = movers == Movers::kConsidered;
    EXPECT_EQ(belief_->used.size(), 13u);
    EXPECT_EQ(belief_->considered, considers ? std::vector{kMover} : std::vector<int>{});
    belief_->state.at(3).error = 100.0;  // not accepted
    frame(tracks);
    EXPECT_THAT(belief_->considered, IsEmpty());
  }
}

TEST_F(FrameLoopOf, GatesEachMeasurementOnItsOwn) {
  start({});
  frame({1, 2, 3});
  belief_->state.at(2).error = 100.0;
  belief_->state.at(3).in_view = false;
  const FrameReport report = frame({1, 2, 3});
  EXPECT_THAT(belief_->used, ElementsAre(1));
  EXPECT_EQ(report.accepted, 1);
  EXPECT_EQ(report.rejected, 1);
  EXPECT_EQ(report.out_of_view, 1);
  EXPECT_EQ(report.negative_inverse_depth, 1);
  EXPECT_EQ(report.state_size, 3);
}

TEST_F(FrameLoopOf, KeepsPredictionsWhereAskedTo) {
  start({});
  frame({1, 2, 3, 4});
  EXPECT_THAT(frame({1, 2, 3, 4}).predictions, IsEmpty());
  loop_->keep_predictions();
  belief_->state.at(2).error = 100.0;
  belief_->state.at(4).in_view = false;
  const FrameReport report = frame({1, 2, 5});
  EXPECT_THAT(calls_, testing::Contains("predict_pixels"));
  std::vector<int> tracks;
  std::vector<Measured> measured;
  for (const Prediction& p : report.predictions) {
    tracks.push_back(p.track);
    measured.push_back(p.measured);
  }
  EXPECT_THAT(tracks, ElementsAre(1, 2, 3));
  EXPECT_THAT(measured, ElementsAre(Measured::kAccepted, Measured::kRejected, Measured::kNot));
  const Eigen::Vector2d measured_at(320.0, 240.0), error(100.0, 0.0);
  EXPECT_EQ(report.predictions[1].pixel, measured_at - error);
  EXPECT_EQ(report.predictions[0].S, Eigen::Matrix2d::Identity());
}

// e^-0.5 is not negative.
TEST_F(FrameLoopOf, CountsNegativeDepthsOfTheParametrisation) {
  ModelOptions models;
  models.point = "log_inverse_depth";
  start(models);
  frame({1, 2});
  belief_->state.at(2).in_view = false;
  EXPECT_EQ(frame({1, 2}).negative_inverse_depth, 0);
}

TEST_F(FrameLoopOf, RefusesAPriorAtInfinityWhereThereIsNone) {
  setup_.prior.inverse_depth = 0.0;
  for (const PointFunctions& point : point_table()) {
    ModelOptions models;
    models.point = point.name;
    const bool has_infinity = point.name == "inverse_depth" || point.name == "homogeneous";
    if (has_infinity) {
      EXPECT_NO_THROW(start(models)) << point.name;
    } else {
      EXPECT_THROW(start(models), std::invalid_argument) << point.name;
    }
  }
}

TEST_F(FrameLoopOf, ClassifiesAndCollapses) {
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
TEST_F(FrameLoopOf, WhatIsBeyondInfinityIsNotStatic) {
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
TEST_F(FrameLoopOf, AWrongMatchSaysNothingOfALabel) {
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

TEST_F(FrameLoopOf, RevertsAStaticLabelThatTheOtherMeasurementsReject) {
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
  EXPECT_THAT(calls_, testing::Not(testing::Contains("leave_one_out")));
}

TEST_F(FrameLoopOf, UndoesWhatIsRememberedOfARejectedLabel) {
  start({});
  frame({1, 2});
  belief_->remembered = {1};
  belief_->state.at(1).leave_one_out = belief_->state.at(2).leave_one_out = 30.0;
  frame({1, 2});
  frame({1, 2});
  EXPECT_EQ(label(1), Label::kUnknown);
  EXPECT_EQ(label(2), Label::kUnknown);
  EXPECT_EQ(std::ranges::count(calls_, "release"), 1);
  EXPECT_EQ(std::ranges::count(calls_, "free"), 1);
}

TEST_F(FrameLoopOf, UndoesTheSurestOfAFrame) {
  start({});
  frame({1, 2, 3});
  belief_->remembered = {1, 2, 3};
  belief_->state.at(1).leave_one_out = belief_->state.at(2).leave_one_out = 30.0;
  frame({1, 2, 3});
  frame({1, 2, 3});
  EXPECT_EQ(label(1), Label::kStatic);
  EXPECT_EQ(label(2), Label::kUnknown);
  EXPECT_EQ(label(3), Label::kStatic);  // not rejected
  frame({1, 2, 3});
  EXPECT_EQ(label(1), Label::kUnknown);
}

// Of labels of the first frame; all frames so far are processed again without it.
TEST_F(FrameLoopOf, StartsOverWithoutARejectedLabel) {
  ModelOptions models;
  models.classifier.name = "thesis";
  start_with(models);
  frame({1, 2});
  EXPECT_EQ(label(1), Label::kStatic);
  EXPECT_FALSE(loop_->records().at(1).by_rule);
  belief_->state.at(1).leave_one_out = 30.0;
  frame({1, 2});
  EXPECT_EQ(label(1), Label::kStatic);
  const FakeBelief* before = belief_;
  const FrameReport report = frame({1, 2, 3});
  EXPECT_NE(belief_, before);
  EXPECT_EQ(std::ranges::count(calls_, "predict"), 1 + 3);
  EXPECT_NEAR(belief_->last_dt, 0.1, 1e-15);
  EXPECT_EQ(report.admitted, 1);  // of the newest frame
  EXPECT_EQ(label(1), Label::kUnknown);
  EXPECT_EQ(label(2), Label::kStatic);
  EXPECT_THAT(calls_, testing::Not(testing::Contains("free")));
}

// A motion that is remembered from birth; then for so long, while it is seen, and in doubt.
TEST_F(FrameLoopOf, ForgetsMotions) {
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
  for (int i = 0; i < 4; ++i) frame({1, 2});
  EXPECT_THAT(belief_->remembered, ElementsAre(1, 3));  // not seen five times
  frame({1, 2});
  EXPECT_THAT(belief_->remembered, ElementsAre(1));
  frame({1, 2});
  EXPECT_THAT(belief_->remembered, ElementsAre(1));  // for seven frames
  frame({1, 2});
  EXPECT_THAT(belief_->remembered, IsEmpty());
  EXPECT_EQ(label(1), Label::kStatic);
}

// What its motion would be says sooner than innovations that a label is wrong.
TEST_F(FrameLoopOf, StartsOverWithoutTheSurestMoverOfTheFirstFrame) {
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
  EXPECT_EQ(std::ranges::count(calls_, "predict"), 1 + 2 * 2);
  EXPECT_THAT(calls_, testing::Not(testing::Contains("release")));
}

TEST_F(FrameLoopOf, StartsOverWithoutTheMostRejectedWhereNothingIsRemembered) {
  start_with({});
  frame({1, 2, 3});
  belief_->state.at(1).leave_one_out = 20.0;
  belief_->state.at(2).leave_one_out = 30.0;
  frame({1, 2, 3});
  frame({1, 2, 3});
  EXPECT_EQ(label(1), Label::kStatic);
  EXPECT_EQ(label(2), Label::kUnknown);
  EXPECT_EQ(label(3), Label::kStatic);
  EXPECT_THAT(calls_, testing::Not(testing::Contains("free")));
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
