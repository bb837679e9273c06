// The default scenario from its first frame to its last, with the default configuration, but a
// window of ten frames, for which the bar was stated: frames a second, and what the stages have of
// it. Means over the whole run, because the map grows.
#include <benchmark/benchmark.h>

#include "bench/frame_times.h"
#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"

namespace slammot::bench {
namespace {

void circle(benchmark::State& state, const std::string& estimator) {
  const Sequence sequence = simulate("circle", {}, 1);
  Configuration configuration;
  configuration.window.frames = 10;
  const Setup setup = make_setup(sequence, configuration);
  for (auto _ : state) {
    const FrameTimes times = time_frames(setup, sequence.frames, estimator, configuration, 0);
    const double total = times.mean("total");
    state.SetIterationTime(1e-3 * total);
    for (const auto& [stage, ms] : times.stages) state.counters[stage] = times.mean(stage);
    state.counters["frames_per_second"] = 1e3 / total;
    state.counters["classification_share"] = times.mean("classify") / total;
    state.counters["collapse_share"] = times.mean("collapse") / total;
  }
}
BENCHMARK_CAPTURE(circle, ekf, "ekf")->Apply(one_pass);
BENCHMARK_CAPTURE(circle, window, "window")->Apply(one_pass);

}  // namespace
}  // namespace slammot::bench
