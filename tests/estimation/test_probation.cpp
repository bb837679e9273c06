#include "estimation/probation.h"

#include <gtest/gtest.h>

namespace slammot {
namespace {

Frame frame_at(int index, double time, std::vector<int> tracks) {
  Frame frame{index, time, {}};
  for (const int track : tracks) {
    frame.observations.push_back({track, {1.0 * index, 1.0 * track}});
  }
  return frame;
}

class ProbationOfThree : public testing::Test {
 protected:
  void note(int index, double time, std::vector<int> tracks) {
    const Frame frame = frame_at(index, time, std::move(tracks));
    probation_.note(frame, frame.observations);
  }
  Probation probation_{3};
};

TEST_F(ProbationOfThree, EndsWithTheThirdFrameInARow) {
  note(4, 1.0, {7, 8});
  EXPECT_FALSE(probation_.is_passed(7));
  note(6, 1.5, {7});  // frame 5 was left out of the sequence
  ASSERT_TRUE(probation_.is_passed(7));
  EXPECT_FALSE(probation_.is_passed(8));
  const std::vector<Sighting> seen = probation_.sightings(7, 1.75);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0].frames_before, 2);
  EXPECT_EQ(seen[0].frame, 4);
  EXPECT_EQ(seen[0].to_next, 0.5);
  EXPECT_EQ(seen[0].z.pixel, Eigen::Vector2d(4.0, 7.0));
  EXPECT_EQ(seen[1].frames_before, 1);
  EXPECT_EQ(seen[1].to_next, 0.25);
}

TEST_F(ProbationOfThree, BeginsAnewAfterAFrameWithoutTheTrack) {
  note(0, 0.0, {7});
  note(1, 0.1, {});
  note(2, 0.2, {7});
  EXPECT_FALSE(probation_.is_passed(7));
  note(3, 0.3, {7});
  EXPECT_EQ(probation_.sightings(7, 0.4).front().frame, 2);
}

TEST_F(ProbationOfThree, KeepsTheNewestWhereThereWasNoRoom) {
  for (int i = 0; i < 5; ++i) note(i, 0.1 * i, {7});
  EXPECT_EQ(probation_.sightings(7, 0.5).front().frame, 3);
  probation_.forget(7);
  EXPECT_FALSE(probation_.is_passed(7));
}

TEST(Probation, OfOneFrameIsOff) {
  EXPECT_FALSE(Probation(1).is_on());
  EXPECT_TRUE(Probation(2).is_on());
  EXPECT_THROW(Probation(0), std::invalid_argument);
}

}  // namespace
}  // namespace slammot
