// Odds from outside in both families: the default ones change nothing, right ones decide sooner,
// and wrong ones are overcome.
#include <gtest/gtest.h>

#include <set>

#include "datasets/simulation/scenario.h"
#include "eval/metrics/labels/classification_table.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

class OutsideOddsOf : public testing::TestWithParam<std::string> {
 protected:
  RunResult run(const std::map<int, double>& p_static) {
    sequence_.p_static = p_static;
    return run_estimator(sequence_, {}, GetParam());
  }
  // Of each landmark its class with this probability, of those in `wrong` the other one.
  std::map<int, double> odds(double sure, const std::set<int>& wrong) const {
    std::map<int, double> result;
    for (const auto& [track, landmark] : sequence_.landmarks) {
      const bool says_static = (landmark.label == Label::kStatic) != wrong.contains(track);
      result[track] = says_static ? sure : 1.0 - sure;
    }
    return result;
  }
  Sequence sequence_ = simulate("circle", {{"frames", "60"}}, 3);
};

// The odds of 2 : 1 that the classifier has by default.
TEST_P(OutsideOddsOf, ThoseOfTheDefaultChangeNothing) {
  std::map<int, double> same;
  for (const auto& [track, landmark] : sequence_.landmarks) same[track] = 2.0 / 3.0;
  const RunResult without = run({}), with = run(same);
  for (std::size_t i = 0; i < without.filtered.size(); ++i) {
    ASSERT_EQ(with.filtered[i].state.position, without.filtered[i].state.position) << i;
  }
  EXPECT_EQ(with.in_force->size(), without.in_force->size() + 1);
}

TEST_P(OutsideOddsOf, RightOnesDecideSooner) {
  const auto judge = [&](const std::map<int, double>& p_static) {
    const RunResult result = run(p_static);
    double measured = 0.0;  // until the decision, or in all
    for (const ClassificationRecord& r : result.classification) measured += r.observations;
    return std::pair(classification_metrics(result.classification),
                     measured / static_cast<double>(result.classification.size()));
  };
  const auto [without, slow] = judge({});
  const auto [with, fast] = judge(odds(0.99, {}));
  std::printf("measurements to decision, mean: %.2f without, %.2f with\n", slow, fast);
  EXPECT_LT(fast, 0.9 * slow);
  EXPECT_GE(with.statics.right, without.statics.right);
  EXPECT_GE(with.movings.right, without.movings.right);
  EXPECT_LE(with.statics.wrong + with.movings.wrong, without.statics.wrong + without.movings.wrong);
}

// Of every fifth landmark the wrong class is said: of most of both classes the right label is found
// all the same.
TEST_P(OutsideOddsOf, WrongOnesAreOvercome) {
  std::set<int> wrong;
  for (const auto& [track, landmark] : sequence_.landmarks) {
    if (track % 5 == 0) wrong.insert(track);
  }
  std::map<Label, int> all, right;
  for (const ClassificationRecord& record : run(odds(0.9, wrong)).classification) {
    if (!record.truth || !wrong.contains(record.track)) continue;
    ++all[*record.truth];
    right[*record.truth] += record.label == *record.truth ? 1 : 0;
  }
  for (const Label truth : {Label::kStatic, Label::kMoving}) {
    std::printf("%s: %d of %d right\n", std::string(to_string(truth)).c_str(), right[truth],
                all[truth]);
    EXPECT_GT(all[truth], 5);
    EXPECT_GT(3 * right[truth], 2 * all[truth]);
  }
}

INSTANTIATE_TEST_SUITE_P(Families, OutsideOddsOf, testing::Values("ekf", "window"),
                         [](const auto& family) { return family.param; });

}  // namespace
}  // namespace slammot
