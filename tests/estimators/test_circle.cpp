// The default scenario, shortened, with a third of the map of the first frame moving. The run
// starts over without wrong labels (test_loop_labels.cpp). Studies: believable, first_frame.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/run/process.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

class Circle : public testing::TestWithParam<const char*> {};

// Six movers of the first frame among 12 static points. Counted are those measured ten times.
TEST_P(Circle, NeitherLosesTheCameraNorKeepsAMapOfMovers) {
  prepare_process();  // BLAS threads would only wait for each other
  std::map<Label, int> labels;
  for (const unsigned seed : {1u, 2u}) {
    const Sequence sequence =
        simulate("circle", {{"frames", "90"}, {"first_moving", "6"}, {"moving", "600"}}, seed);
    const RunResult run = run_estimator(sequence, {}, GetParam());
    ASSERT_EQ(run.filtered.size(), sequence.frames.size());
    for (std::size_t i = 0; i < run.filtered.size(); ++i) {
      const Eigen::Vector3d& p = run.filtered[i].state.position;
      EXPECT_LT((p - sequence.truth[i]->position).norm(), 0.05 * 12.6) << i;  // of the path
    }
    for (const LandmarkRecord& l : run.landmarks) {
      const TrueLandmark& truth = sequence.landmarks.at(l.estimate.track);
      const bool is_poison = truth.label == Label::kMoving && truth.at(0) != nullptr;
      if (is_poison && l.estimate.observations >= 10) ++labels[l.estimate.label];
    }
  }
  EXPECT_GT(labels[Label::kMoving], 5 * labels[Label::kStatic]);
}

INSTANTIATE_TEST_SUITE_P(Families, Circle, testing::Values("ekf", "window"));

}  // namespace
}  // namespace slammot
