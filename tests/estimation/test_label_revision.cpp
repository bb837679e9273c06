// Labels that may be taken back, on innovations whose distribution is known.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estimation/gate.h"
#include "estimation/modules/label_revision.h"

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
      rejected = is_rejected(record);
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
  EXPECT_FALSE(is_rejected(record));  // far away, four sigma
  note_depth(record, {-0.06, 0.01}, with_rule(LabelRule::kOneWay));
  EXPECT_FALSE(is_rejected(record));
  note_depth(record, {-0.06, 0.01}, reversible());
  EXPECT_TRUE(is_rejected(record));
  note_reverted(record);
  EXPECT_FALSE(is_rejected(record));
  EXPECT_TRUE(record.cannot_rest);
}

TEST(Reversible, WhatIsKnownBeforehandStays) {
  TrackRecord known = initialised(2, 0, Label::kStatic, {});
  known.known = true;
  note_depth(known, {-0.06, 0.01}, reversible());
  for (int i = 0; i < 20; ++i) note_innovation(known, 100.0, reversible());
  EXPECT_FALSE(is_rejected(known));
}

TEST(Reversible, OnlyTheLatestInnovationsCount) {
  const LabelOptions options = reversible();
  TrackRecord record = initialised(1, 0, Label::kStatic, {});
  for (int i = 0; i < 1000; ++i) note_innovation(record, 2.0, options);
  for (int i = 0; i < 5; ++i) note_innovation(record, 10.0, options);
  EXPECT_TRUE(is_rejected(record));  // 60 over 10 frames, not 2050 over 1005
  note_reverted(record);
  EXPECT_EQ(record.label, Label::kUnknown);
  EXPECT_FALSE(record.decision_frame);
  EXPECT_FALSE(is_rejected(record));
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

// Static landmarks, of which those in `rejected` are so by their innovations.
TrackRecords static_records(const std::vector<int>& tracks, const std::vector<int>& rejected) {
  TrackRecords records;
  for (const int track : tracks) records[track] = initialised(track, 0, Label::kStatic, {});
  for (const int track : rejected) records.at(track).static_nis = {50.0, 50.0};
  return records;
}

MotionBelief motion(int track, double distance, double sigma = 1.0) {
  MotionBelief b;
  b.track = track;
  b.w = distance * sigma * Eigen::Vector3d::UnitX();
  b.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  b.prior_sigmas = MotionVector::Ones(3);
  return b;
}

class UndoingOf : public testing::Test {
 protected:
  void add(int track, double distance, double sigma = 1.0) {
    if (motions_.size() == 0) motions_.reset(6, 3);
    const std::size_t i = motions_.size();
    motions_.add(track, Eigen::Vector3d::UnitZ());
    motions_.information(i, i) = Eigen::Matrix3d::Identity() / (sigma * sigma);
    motions_.vector(i) = distance / sigma * Eigen::Vector3d::UnitX();
  }
  // The classifier says that these move, however little.
  void find(const TrackRecords& records, const std::set<int>& moving) {
    const auto ask = [&](std::size_t i) -> std::optional<MotionAnswer> {
      auto motion = motions_.motion(i, find_landmark("scaled_velocity", "inverse_depth"));
      if (!motion) return std::nullopt;
      motion->prior_sigmas = MotionVector::Ones(3);
      const bool moves = moving.contains(motion->track);
      return MotionAnswer{*motion, moves ? Label::kMoving : Label::kUnknown};
    };
    find_undoing(records, tracks_, motions_, ask, undoing_);
  }

  const std::vector<int> tracks_{1, 2, 3, 4, 5, 6};
  RememberedMotions motions_;
  Undoing undoing_{{99}, {99}};
};

TEST_F(UndoingOf, TheMostSignificantRememberedFirstAndAllOthersThatAreRejected) {
  add(1, 9.0);
  add(2, 3.0);
  add(3, 4.0, 0.01);
  add(4, 5.0, 0.01);
  // 1 moves most, but the classifier does not say so; innovations that reject 2 suffice.
  find(static_records(tracks_, {2, 5, 6}), {3, 4});
  EXPECT_EQ(undoing_.release, (std::vector<int>{4, 3, 2}));
  EXPECT_EQ(undoing_.free, (std::vector<int>{5, 6}));
}

TEST_F(UndoingOf, NoMoreThanThreeInAFrame) {
  for (const int track : tracks_) add(track, track);
  find(static_records(tracks_, {}), {1, 2, 3, 4, 5, 6});
  EXPECT_EQ(undoing_.release, (std::vector<int>{6, 5, 4}));
}

// From its second measurement on, and unless they make the odds of rest three times as large: by
// s^-3 exp(-d^2/2) where all three directions have a unit prior. Half of what rests
// at most, the most significant first.
TEST_F(UndoingOf, HeldAndMeasuredTwiceItMustSpeakForRest) {
  TrackRecords records = static_records(tracks_, {});
  for (const int track : {1, 2, 3, 5, 6}) {
    records.at(track).label = Label::kUnknown;
    records.at(track).is_held = true;
    records.at(track).observations = 2;
  }
  add(1, 0.1, std::cbrt(0.34));  // 2.9
  add(2, 0.1, std::cbrt(0.32));  // 3.1
  add(3, 1.7, std::cbrt(0.24));  // 0.98
  add(4, 1.7);                   // it has its label, and keeps it
  add(5, 1.8);
  add(6, 1.9);
  find(records, {});
  EXPECT_EQ(undoing_.release, (std::vector<int>{6, 5, 3}));
  records.at(6).is_held = false;
  motions_ = {};
  add(1, 0.1, std::cbrt(0.34));
  add(2, 0.1, std::cbrt(0.32));
  add(6, 1.9);  // its label too it keeps
  find(records, {});
  EXPECT_EQ(undoing_.release, (std::vector<int>{1}));
  for (const int track : {1, 3, 5, 6}) records.at(track).observations = 1;
  motions_ = {};
  add(1, 1.7);
  add(3, 1.7);
  find(records, {});
  EXPECT_TRUE(undoing_.release.empty());
}

TEST_F(UndoingOf, NothingWhereNothingSpeaksAgainstALabel) {
  add(1, 9.0);
  find(static_records(tracks_, {}), {});
  EXPECT_TRUE(undoing_.release.empty());
  EXPECT_TRUE(undoing_.free.empty());
}

// What a mover bends makes another look moving: not once the mover is released.
TEST_F(UndoingOf, AsksTheOthersWithoutWhatIsReleased) {
  add(1, 0.0);
  add(2, 0.0);
  // w = (6, 4) by the joint information, of which 2 has its part from 1 alone.
  motions_.information(0, 1) = motions_.information(1, 0) = -0.8 * Eigen::Matrix3d::Identity();
  motions_.vector(0) = 6.0 * Eigen::Vector3d::UnitX();
  motions_.vector(1) = -4.8 * Eigen::Vector3d::UnitX();
  const auto& functions = find_landmark("scaled_velocity", "inverse_depth");
  EXPECT_NEAR(motions_.motion(1, functions)->w.x(), -4.8, 1e-12);
  ASSERT_TRUE(motions_.release(0));
  EXPECT_NEAR(motions_.motion(1, functions)->w.x(), 0.0, 1e-12);
  EXPECT_NEAR(motions_.motion(1, functions)->covariance(0, 0), 1.0 / 0.36, 1e-12);
}

TEST(RememberedMotion, IsForgottenWithAgeUnseenAndBeyondDoubt) {
  constexpr int kMemory = 60;
  TrackRecord record = initialised(1, 0, Label::kStatic, {});
  record.remembered_frames = kMemory - 1;
  record.unused_frames = 4;
  EXPECT_FALSE(is_forgotten(record, kMemory));
  ++record.unused_frames;
  EXPECT_TRUE(is_forgotten(record, kMemory));
  record.unused_frames = 0;
  ++record.remembered_frames;
  EXPECT_TRUE(is_forgotten(record, kMemory));

  record.remembered_frames = 0;
  const double ratio = std::pow(1e4, 1.0 / 3.0);  // at rest the odds are its cube
  note_motion(record, motion(1, 0.0, 1.001 / ratio));
  EXPECT_FALSE(is_forgotten(record, kMemory));
  note_motion(record, motion(1, 0.2, 0.999 / ratio));
  EXPECT_FALSE(is_forgotten(record, kMemory));
  note_motion(record, motion(1, 0.0, 0.999 / ratio));
  EXPECT_TRUE(is_forgotten(record, kMemory));
  note_motion(record, motion(1, 9.0));  // no more: it is gone at the next frame
  EXPECT_TRUE(is_forgotten(record, kMemory));
  note_reverted(record);
  EXPECT_FALSE(is_forgotten(record, kMemory));
}

TEST(RememberedMotion, NeedsAVelocityThatIsConditionedAndMayBeReleased) {
  const LandmarkFunctions& velocity = find_landmark("scaled_velocity", "inverse_depth");
  ModelOptions models;
  models.labels.memory = 7;
  EXPECT_EQ(motion_memory(models, velocity), 7);
  const auto without = [&](auto&& change, const LandmarkFunctions& landmark) {
    ModelOptions other = models;
    change(other);
    EXPECT_EQ(motion_memory(other, landmark), 0);
    return why_no_memory(other, landmark);
  };
  const auto nothing = [](ModelOptions&) {};
  EXPECT_EQ(without([](auto& m) { m.labels.rule = LabelRule::kOneWay; }, velocity),
            "labels=one_way");
  EXPECT_EQ(without([](auto& m) { m.collapse = Collapse::kDrop; }, velocity), "collapse=drop");
  EXPECT_EQ(without([](auto& m) { m.policy.delayed = true; }, velocity), "estimator delayed");
  EXPECT_EQ(without(nothing, find_landmark("constant_acceleration", "inverse_depth")),
            "landmark=constant_acceleration");
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
