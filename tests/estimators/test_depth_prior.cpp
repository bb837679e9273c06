// prior.source reaches the estimators: with a wrong guess of the depths, and few landmarks known,
// the map finds the scale that the statement loses.
#include <gtest/gtest.h>

#include <cmath>

#include "datasets/simulation/scenario.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

class WrongGuess : public testing::TestWithParam<std::string> {};

TEST_P(WrongGuess, TheMapCorrectsIt) {
  const Sequence sequence = simulate("circle", {{"frames", "100"}}, 1);
  const auto position_error = [&](const std::string& source) {
    Configuration configuration;
    assign(configuration, {"prior.source", source});
    assign(configuration, {"window.frames", "3"});
    assign(configuration, {"prior.inverse_depth", "0.025"});  // the scene's: 0.079 +- 0.020
    assign(configuration, {"prior.inverse_depth_sigma", "0.01"});
    const RunResult run = run_estimator(sequence, configuration, GetParam());
    EXPECT_FALSE(run.diverged);
    double squares = 0.0;
    for (std::size_t i = 0; i < run.filtered.size(); ++i) {
      squares += (run.filtered[i].state.position - sequence.truth[i]->position).squaredNorm();
    }
    return std::sqrt(squares / static_cast<double>(run.filtered.size()));
  };
  const double stated = position_error("fixed"), map = position_error("empirical");
  std::printf("position off by: stated %.3f m, map %.3f m\n", stated, map);
  EXPECT_LT(map, 0.5 * stated);
}

INSTANTIATE_TEST_SUITE_P(Estimators, WrongGuess, testing::Values("ekf", "window"),
                         [](const auto& tested) { return tested.param; });

}  // namespace
}  // namespace slammot
