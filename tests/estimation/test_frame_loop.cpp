// The frame loop, driven with a belief that is told what to say: what it asks, in which order, and
// what it makes of the answers on motion and measurements. On labels: test_loop_labels.cpp.
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
  Frame again{index_, 0.1 * (index_ - 1), {}, {}};
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

class Jolts : public FrameLoopOf {
 protected:
  // Static landmarks from 1 on are off by these [px], and the camera's motion by one in each of
  // them: how often its step is widened. A landmark that is known may enter in the same frame.
  std::ptrdiff_t widened(const std::vector<double>& errors, bool adaptive = true,
                         bool one_enters = false) {
    index_ = 0;
    setup_.known.clear();
    if (one_enters) setup_.known.push_back({50, {0.0, 0.0, 2.0}, 0.01});
    ModelOptions models;
    models.adaptive_motion = adaptive;
    start(models);
    std::vector<int> tracks(errors.size());
    std::iota(tracks.begin(), tracks.end(), 1);
    frame(tracks);
    belief_->shared = 1.0;
    for (const int track : tracks) {
      belief_->state.at(track).error = errors[static_cast<std::size_t>(track - 1)];
    }
    if (one_enters) tracks.push_back(50);
    frame(tracks);
    return count("widen");
  }

  // Of the frame after it, as a part of what is stated.
  double next_noise(const std::vector<int>& tracks) {
    frame(tracks);
    return belief_->last_noise.acceleration / setup_.camera_noise.acceleration;
  }
};

// All are off by the same six pixels: the camera was jolted, its step is widened, and the gate is
// asked again. Not where that is switched off, where too few of them are seen, nor where a landmark
// has just entered at this camera.
TEST_F(Jolts, WidenTheirOwnStepWhereFiveAgree) {
  EXPECT_EQ(widened({6, 6, 6, 6, 6}), 1);
  EXPECT_DOUBLE_EQ(belief_->shared, 36.0 / (1.0 + 1.0) / 2.0);
  EXPECT_EQ(count("innovations"), 2);
  EXPECT_GT(next_noise({1, 2, 3, 4, 5}), 1.0);
  EXPECT_EQ(widened({6, 6, 6, 6, 6}, false), 0);
  EXPECT_EQ(widened({6, 6, 6, 6}), 0);
  EXPECT_EQ(widened({6, 6, 6, 6, 6}, true, true), 0);
  EXPECT_EQ(widened({50, 0, 0, 50, 0}), 0);          // wrong matches or labels
  EXPECT_EQ(widened({3.4, 3.4, 3.4, 3.4, 100}), 0);  // most, but too few to tell of the camera
  EXPECT_EQ(next_noise({1, 2, 3, 4, 5}), 1.0);
}

// No motion of the camera makes most of them agree, or five of them: their matches are wrong. The
// step stays as it was, and nothing is learnt from it.
TEST_F(Jolts, AreNotWhatWrongMatchesAre) {
  const std::vector<double> five{0, 0, 0, 0, 0, 40, 80, 120, 160, 200, 240};
  const std::vector<double> three{0, 0, 0, 40, 80, 120, 160};
  for (const auto& errors : {five, three}) {
    EXPECT_EQ(widened(errors), 2);
    EXPECT_NEAR(belief_->shared, 1.0, 1e-12);
    std::vector<int> right(static_cast<std::size_t>(std::ranges::count(errors, 0.0)));
    std::iota(right.begin(), right.end(), 1);
    EXPECT_EQ(belief_->used, right);
    EXPECT_EQ(next_noise(right), 1.0);
  }
}

// Among twelve that rest, and among eleven. Of all cases: test_consider.cpp.
TEST_F(FrameLoopOf, TellsWhomTheCameraDoesNotFollow) {
  std::vector<int> tracks(13);
  std::iota(tracks.begin(), tracks.end(), 1);
  for (const int track : tracks) setup_.true_labels[track] = Label::kStatic;
  setup_.true_labels[13] = Label::kMoving;
  ModelOptions models;
  models.classifier.name = "truth";
  models.policy.movers = Movers::kConsidered;
  start_with(models);
  frame(tracks);
  frame(tracks);
  EXPECT_EQ(belief_->used.size(), 13u);
  EXPECT_THAT(belief_->considered, ElementsAre(13));
  belief_->state.at(3).error = 100.0;  // not accepted
  frame(tracks);
  EXPECT_THAT(belief_->considered, IsEmpty());
}

TEST_F(FrameLoopOf, GatesEachMeasurementOnItsOwn) {
  for (const char* point : {"inverse_depth", "log_inverse_depth"}) {
    index_ = 0;
    ModelOptions models;
    models.point = point;
    start(models);
    frame({1, 2, 3});
    belief_->state.at(2).error = 100.0;
    belief_->state.at(3).in_view = false;
    const FrameReport report = frame({1, 2, 3});
    EXPECT_THAT(belief_->used, ElementsAre(1));
    EXPECT_EQ(report.accepted, 1);
    EXPECT_EQ(report.rejected, 1);
    EXPECT_EQ(report.out_of_view, 1);
    const bool has_infinity = models.point == "inverse_depth";  // e^-0.5 is not negative
    EXPECT_EQ(report.negative_inverse_depth, has_infinity ? 1 : 0);
    EXPECT_EQ(report.state_size, 3);
  }
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

}  // namespace
}  // namespace slammot
