// A map poisoned by wrong static labels: movers of the first frame, which the thesis's rule takes
// for static (figure 4.5). With one-way labels a landmark is given up only after it has failed the
// gate many times in a row, and what it did to the camera until then stays; with reversible labels
// it is free as soon as its innovations reject the label.
#include <gtest/gtest.h>

#include "slammot/datasets/scenario.h"
#include "slammot/eval/run.h"

namespace slammot {
namespace {

constexpr int kPoison = 6;  // movers of the first frame, among 12 and more static points

class PoisonedMap : public testing::TestWithParam<std::string> {
 protected:
  RunResult run(const std::string& labels) const {
    Configuration configuration;
    configuration.model.labels.name = labels;
    return run_estimator(sequence_, configuration, GetParam());
  }

  // Of the movers of the first frame that were measured ten times: how often each label.
  std::map<Label, int> labels(const RunResult& result) const {
    std::map<Label, int> count;
    for (const LandmarkRecord& l : result.landmarks) {
      const auto truth = sequence_.landmarks.find(l.estimate.track);
      const bool mover = truth->second.label == Label::kMoving;
      const bool first = truth->second.at(0) != nullptr;
      if (mover && first && l.estimate.observations >= 10) ++count[l.estimate.label];
    }
    return count;
  }

  double final_error(const RunResult& result) const {
    return (result.filtered.back().state.position - sequence_.truth.back()->position).norm();
  }

  Sequence sequence_ =
      simulate("circle",
               {{"frames", "90"}, {"first_moving", std::to_string(kPoison)}, {"moving", "600"}}, 1);
};

TEST_P(PoisonedMap, RecoversWithReversibleLabels) {
  const RunResult reversible = run("reversible"), one_way = run("one_way");
  ASSERT_FALSE(reversible.diverged);
  std::map<Label, int> after = labels(reversible), before = labels(one_way);
  std::printf(
      "reversible: %d static, %d moving, %d unknown, error %.3f m; one way: %d, %d, %d, "
      "%.3f m\n",
      after[Label::kStatic], after[Label::kMoving], after[Label::kUnknown], final_error(reversible),
      before[Label::kStatic], before[Label::kMoving], before[Label::kUnknown],
      final_error(one_way));
  EXPECT_EQ(after[Label::kStatic], 0);
  EXPECT_GE(after[Label::kMoving], 2);
  EXPECT_LT(final_error(reversible), final_error(one_way));
  EXPECT_LT(final_error(reversible), 0.2);
}

INSTANTIATE_TEST_SUITE_P(Labels, PoisonedMap, testing::Values("ekf", "window"),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace slammot
