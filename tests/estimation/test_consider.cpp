// Who may correct the camera: which accepted measurements are considered only.
#include "estimation/modules/consider.h"

#include <gtest/gtest.h>

namespace slammot {
namespace {

// Measurements of tracks from 1 on with these labels, those that are considered.
std::vector<int> considered(int rest, const std::vector<Label>& others, const TrackPolicy& policy) {
  std::vector<Observation> accepted;
  TrackRecords records;
  const auto measure = [&](Label label) {
    const int track = static_cast<int>(accepted.size()) + 1;
    accepted.push_back({track, Eigen::Vector2d::Zero()});
    records[track] = initialised(track, 0, label, {});
  };
  for (const Label label : others) measure(label);
  for (int i = 0; i < rest; ++i) measure(Label::kStatic);
  records[1000] = initialised(1000, 0, Label::kMoving, {});  // not measured
  std::vector<int> result{99};
  find_considered(accepted, records, policy, result);
  return result;
}

const std::vector<Label> kOthers{Label::kMoving, Label::kUnknown, Label::kMoving};

TEST(Considered, AreMoversWhereEnoughRests) {
  TrackPolicy policy;
  policy.movers = Movers::kConsidered;
  EXPECT_EQ(kStaticEnough, 12);
  EXPECT_EQ(considered(12, kOthers, policy), (std::vector<int>{1, 3}));
  EXPECT_EQ(considered(11, kOthers, policy), std::vector<int>{});
  policy.movers = Movers::kJoint;
  EXPECT_EQ(considered(12, kOthers, policy), std::vector<int>{});
}

TEST(Considered, AreUnknownOnesWhereInitialisationIsDelayed) {
  TrackPolicy policy;
  policy.delayed = true;
  policy.movers = Movers::kJoint;
  EXPECT_EQ(considered(0, kOthers, policy), std::vector<int>{2});
  policy.movers = Movers::kConsidered;
  EXPECT_EQ(considered(12, kOthers, policy), (std::vector<int>{1, 2, 3}));
}

}  // namespace
}  // namespace slammot
