// Measurements that are each half as exact, beside a pixel_sigma of half a pixel, are those of one
// pixel: to the last bit, wherever an estimator uses a measurement.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/simulation/scenario.h"
#include "eval/configuration/configuration.h"
#include "eval/run/run.h"

namespace slammot {
namespace {

struct Run {
  std::string name, estimator;
  std::vector<std::string> settings;
  int frames = 25;
};

void PrintTo(const Run& c, std::ostream* out) { *out << c.name; }

class RelativeSigma : public testing::TestWithParam<Run> {};

TEST_P(RelativeSigma, TimesPixelSigmaIsTheNoise) {
  const Sequence sequence = simulate("circle", {{"frames", std::to_string(GetParam().frames)}}, 4);
  ASSERT_EQ(sequence.pixel_sigma, 1.0);
  Sequence scaled = sequence;
  scaled.pixel_sigma = 0.5;
  for (Frame& frame : scaled.frames) {
    for (Observation& z : frame.observations) z.relative_sigma = 2.0;
  }
  Configuration configuration;
  for (const std::string& setting : GetParam().settings) {
    assign(configuration, parse_assignment(setting));
  }
  const RunResult a = run_estimator(sequence, configuration, GetParam().estimator);
  const RunResult b = run_estimator(scaled, configuration, GetParam().estimator);
  ASSERT_EQ(std::ssize(a.filtered), GetParam().frames);
  ASSERT_EQ(b.filtered.size(), a.filtered.size());
  for (std::size_t i = 0; i < a.filtered.size(); ++i) {
    ASSERT_EQ(a.filtered[i].state.position, b.filtered[i].state.position) << "frame " << i;
    ASSERT_EQ(a.filtered[i].covariance, b.filtered[i].covariance) << "frame " << i;
    ASSERT_EQ(a.counts[i].joint_nis, b.counts[i].joint_nis) << "frame " << i;
  }
  EXPECT_THAT(b.ray_spread, testing::Pointwise(testing::NanSensitiveDoubleEq(), a.ray_spread));
  ASSERT_EQ(a.smoothed.size(), b.smoothed.size());
  for (std::size_t i = 0; i < a.smoothed.size(); ++i) {
    ASSERT_EQ(a.smoothed[i].state.position, b.smoothed[i].state.position) << "smoothed " << i;
  }
}

const Run kCases[] = {
    {"ekf", "ekf", {}},
    {"ekf_joint", "ekf", {"policy.movers=joint"}},
    {"ekf_iterated", "ekf", {"ekf.iterations=3"}},
    {"delayed", "delayed", {}},
    {"window", "window", {"window.frames=8"}},
    {"window_ceres", "window", {"window.frames=3", "window.solver=ceres"}, 3},
    {"batch", "batch", {}, 10},
};
INSTANTIATE_TEST_SUITE_P(Estimators, RelativeSigma, testing::ValuesIn(kCases),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace slammot
