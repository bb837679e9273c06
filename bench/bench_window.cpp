// A frame of the window against one of the EKF on the same data, against its own length, and alone
// on a static world, where a peer's figures are known.
#include <benchmark/benchmark.h>

#include "slammot/bench/corridor.h"
#include "slammot/bench/timing.h"
#include "slammot/eval/registry.h"
#include "slammot/eval/stage_clock.h"

namespace slammot::bench {
namespace {

constexpr int kWarm = 150, kTimed = 100;  // frames

// Medians over the timed frames of each stage [ms].
std::map<std::string, double> median_frame(const Corridor& corridor, const std::string& estimator,
                                           const Configuration& configuration) {
  const auto made = find_estimator(estimator).make(corridor.setup, configuration);
  std::map<std::string, std::vector<double>> stages;
  for (const Frame& frame : corridor.frames) {
    StageClock clock;
    made->process(frame, clock);
    if (frame.index < kWarm) continue;
    for (const auto& [stage, ms] : clock.finish()) stages[stage].push_back(ms);
  }
  std::map<std::string, double> medians;
  for (const auto& [stage, ms] : stages) medians[stage] = median(ms);
  return medians;
}

void report(benchmark::State& state, const std::map<std::string, double>& frame) {
  for (const auto& [stage, ms] : frame) state.counters[stage] = ms;
}

// Range: landmarks in view, length of the window.
void window_frame(benchmark::State& state) {
  const CorridorOptions options{.frames = kWarm + kTimed,
                                .visible = static_cast<int>(state.range(0))};
  const Corridor corridor = make_corridor(options);
  Configuration configuration = corridor_configuration(options);
  configuration.model.policy.retain = "window";
  configuration.window.frames = static_cast<int>(state.range(1));
  for (auto _ : state) {
    const auto window = median_frame(corridor, "window", configuration);
    const auto ekf = median_frame(corridor, "ekf", configuration);
    state.SetIterationTime(1e-3 * window.at("total"));
    report(state, window);
    state.counters["ekf"] = ekf.at("total");
    state.counters["ratio"] = window.at("total") / ekf.at("total");
  }
}
BENCHMARK(window_frame)
    ->Args({30, 5})
    ->Args({30, 10})
    ->Args({30, 20})
    ->Args({30, 40})
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

// Range: landmarks in view, all static and known to be so, none kept once unseen.
void static_window(benchmark::State& state) {
  const CorridorOptions options{.frames = kWarm + kTimed,
                                .visible = static_cast<int>(state.range(0)),
                                .moving_fraction = 0.0};
  const Corridor corridor = make_corridor(options);
  Configuration configuration = corridor_configuration(options);
  configuration.model.policy.retain = "window";
  configuration.model.classifier.name = "all_static";
  for (auto _ : state) {
    const auto window = median_frame(corridor, "window", configuration);
    state.SetIterationTime(1e-3 * window.at("total"));
    report(state, window);
  }
}
BENCHMARK(static_window)
    ->Arg(17)
    ->Arg(30)
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace slammot::bench
