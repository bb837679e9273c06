// The default scenario, shortened: no estimator may lose the camera. On 50 seeds:
// eval/studies/believable.yaml.
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

using Case = std::tuple<std::string, int>;

class Circle : public testing::TestWithParam<Case> {};

// A third of the circle is 21 m long; 5% of that would still be a bad figure, but no lost camera.
TEST_P(Circle, TheCameraIsNotLost) {
  constexpr int kFrames = 150;
  constexpr double kLost = 0.05 * 21.0;
  const auto& [estimator, seed] = GetParam();
  const Sequence whole = simulate("circle", {}, static_cast<unsigned>(seed));
  const Sequence sequence = select_frames(whole, 0, kFrames - 1, 1);
  const RunResult run = run_estimator(sequence, Configuration{}, estimator);
  ASSERT_FALSE(run.diverged);
  ASSERT_EQ(run.filtered.size(), static_cast<std::size_t>(kFrames));
  double worst = 0.0;
  for (std::size_t i = 0; i < run.filtered.size(); ++i) {
    worst = std::max(worst, (run.filtered[i].state.position - sequence.truth[i]->position).norm());
  }
  std::printf("largest error %.3f m\n", worst);
  EXPECT_LT(worst, kLost);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Circle,
                         testing::Combine(testing::Values("ekf", "window"), testing::Range(1, 3)),
                         [](const auto& c) {
                           return std::get<0>(c.param) + "_seed" +
                                  std::to_string(std::get<1>(c.param));
                         });

}  // namespace
}  // namespace slammot
