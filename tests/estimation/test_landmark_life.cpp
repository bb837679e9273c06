// Through the frame loop, with a belief that is told what to say: when landmarks are admitted and
// pruned, and what is learnt of them for those that follow.
#include <gmock/gmock.h>

#include "tests/estimation/frame_loop_fixture.h"

namespace slammot {
namespace {

using test::FakeBelief;
using testing::IsEmpty;

class LandmarkLife : public test::FrameLoopOf {};

TEST_F(LandmarkLife, PrunesWhatIsNotMeasuredAndStartsItsTrackAnew) {
  ModelOptions models;
  models.policy.prune_after = 2;
  start(models);
  frame({});
  frame({1});
  EXPECT_EQ(loop_->records().at(1).label, Label::kUnknown);
  frame({});
  frame({});
  const FrameReport report = frame({});
  ASSERT_EQ(report.retired.size(), 1u);
  EXPECT_EQ(report.retired[0].track, 1);
  EXPECT_THAT(loop_->records(), IsEmpty());
  EXPECT_EQ(frame({1}).admitted, 1);
}

TEST_F(LandmarkLife, PrunesAStaticLandmarkThatShouldBeInViewAndIsNot) {
  ModelOptions models;
  models.policy.prune_after = 1;
  start(models);
  frame({1, 2});
  belief_->state.at(2).in_view = true;
  for (int i = 0; i < kMissedByStatic; ++i) frame({1});
  EXPECT_TRUE(loop_->records().contains(2));  // straight ahead of the camera, six frames missed
  frame({1});
  EXPECT_FALSE(loop_->records().contains(2));
}

TEST_F(LandmarkLife, AdmitsWhatThereIsRoomFor) {
  ModelOptions models;
  models.policy.max_visible = 2;
  start(models);
  EXPECT_EQ(frame({1, 2, 3}).admitted, 2);
  EXPECT_EQ(frame({1, 2, 3}).admitted, 0);  // two are measured
  EXPECT_EQ(frame({1, 3}).admitted, 1);
  EXPECT_EQ(frame({FakeBelief::kNoRay}).admitted, 0);
  EXPECT_FALSE(loop_->records().contains(FakeBelief::kNoRay));
}

// Births go on where the state is full: what was unseen longest leaves.
TEST_F(LandmarkLife, AFullStateMakesRoom) {
  ModelOptions models;
  models.policy.max_landmarks = 3;
  start(models);
  EXPECT_EQ(frame({1, 2, 3}).admitted, 3);
  frame({1, 2});
  const FrameReport report = frame({1, 4});
  EXPECT_EQ(report.admitted, 1);
  ASSERT_EQ(report.retired.size(), 1u);
  EXPECT_EQ(report.retired[0].track, 3);
  EXPECT_FALSE(belief_->state.contains(3));
  EXPECT_EQ(frame({1, 2, 4, 5, 6}).admitted, 0);  // this frame used all
  EXPECT_EQ(frame({1, 4, 5, 6}).admitted, 1);     // as far as there are any
  EXPECT_EQ(loop_->records().size(), 3u);
  EXPECT_TRUE(loop_->records().contains(5));
}

TEST_F(LandmarkLife, LearnsTheDepthPriorFromStaticLandmarks) {
  ModelOptions models;
  models.depth_prior = DepthPriorSource::kEmpirical;
  start(models);
  frame({1, 2, 3, 4});
  EXPECT_EQ(belief_->newest_prior.inverse_depth, setup_.prior.inverse_depth);
  frame({1, 2, 3, 4, 5});
  EXPECT_GT(belief_->newest_prior.inverse_depth, setup_.prior.inverse_depth);  // towards 0.5
}

}  // namespace
}  // namespace slammot
