// Which landmarks are wanted, and which are given up or make room.
#include <gtest/gtest.h>

#include "estimation/track_policy.h"

namespace slammot {
namespace {

TEST(TrackPolicy, SaysWhenALandmarkIsGivenUp) {
  const TrackPolicy policy;
  TrackRecord moving = initialised(1, 0, Label::kUnknown, {});
  moving.unused_frames = policy.prune_after;
  EXPECT_FALSE(is_pruned(moving, policy));
  ++moving.unused_frames;
  EXPECT_TRUE(is_pruned(moving, policy));
  TrackRecord fixed = initialised(2, 0, Label::kStatic, {});
  fixed.unused_frames = 10000;
  EXPECT_FALSE(is_pruned(fixed, policy));  // it stays in the map
  for (int i = 0; i < kMissedByStatic * policy.prune_after; ++i) note_unused(fixed, true);
  note_unused(fixed, false);
  EXPECT_FALSE(is_pruned(fixed, policy));
  note_unused(fixed, true);
  EXPECT_TRUE(is_pruned(fixed, policy));
  note_accepted(fixed, 9);
  EXPECT_FALSE(is_pruned(fixed, policy));
  for (int i = 0; i <= policy.prune_after; ++i) note_rejected(fixed);
  EXPECT_TRUE(is_pruned(fixed, policy));
}

TEST(TrackPolicy, WantsAsManyAsAreToBeMeasured) {
  TrackPolicy policy;
  EXPECT_EQ(births_wanted(0, policy), static_cast<std::size_t>(kUsuallyVisible));
  policy.max_visible = 6;
  EXPECT_EQ(births_wanted(0, policy), 6u);
  EXPECT_EQ(births_wanted(5, policy), 1u);
  EXPECT_EQ(births_wanted(8, policy), 0u);
}

// Static landmarks 1 to 4, unseen for 0, 7, 2 and 7 frames, and a mover unseen for 5.
TEST(TrackPolicy, MakesRoomOfWhatRestsUnseenLongest) {
  TrackRecords records;
  for (const auto& [track, unseen] : {std::pair{1, 0}, {2, 7}, {3, 2}, {4, 7}, {5, 5}}) {
    const Label label = track == 5 ? Label::kMoving : Label::kStatic;
    records[track] = initialised(track, 0, label, {});
    records[track].unused_frames = unseen;
  }
  TrackPolicy policy;
  const auto leave = [&](int most, std::size_t births) {
    policy.max_landmarks = most;
    std::vector<int> result{99};
    make_room(records, births, policy, result);
    return result;
  };
  EXPECT_EQ(leave(10, 5), std::vector<int>{});
  EXPECT_EQ(leave(10, 6), std::vector<int>{2});
  EXPECT_EQ(leave(5, 0), std::vector<int>{});
  EXPECT_EQ(leave(5, 2), (std::vector<int>{2, 4}));
  EXPECT_EQ(leave(5, 3), (std::vector<int>{2, 3, 4}));
  EXPECT_EQ(leave(5, 4), (std::vector<int>{2, 3, 4}));  // the others are seen, or move
}

}  // namespace
}  // namespace slammot
