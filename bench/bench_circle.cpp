// The default scenario from its first frame to its last, with the default configuration: frames a
// second, what the stages have of it, and the window's frame against the arithmetic that it needs.
// Means over the whole run, because the map grows.
#include <benchmark/benchmark.h>

#include "bench/frame_times.h"
#include "datasets/simulation/scenario.h"
#include "eval/configuration/setup.h"

namespace slammot::bench {
namespace {

// `frames`: of the window; 0: of the EKF.
void circle(benchmark::State& state, const std::string& estimator, int frames) {
  const Sequence sequence = simulate("circle", {}, 1);
  Configuration configuration;
  if (frames > 0) configuration.window.frames = frames;
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
BENCHMARK_CAPTURE(circle, ekf, "ekf", 0)->Apply(one_pass);
BENCHMARK_CAPTURE(circle, window, "window", 10)->Apply(one_pass);
BENCHMARK_CAPTURE(circle, window_20, "window", 20)->Apply(one_pass);

// The rate of a bare product of matrices as large as the window's, in multiplications and additions
// [Mflop/ms].
void dgemm(benchmark::State& state) {
  const int n = 400;
  const double one = 1.0, zero = 0.0;
  const std::vector<double> A(n * n, 1e-3), B(n * n, 1.0);
  std::vector<double> C(n * n);
  std::vector<double> times;
  for (auto _ : state) {
    times.push_back(milliseconds([&] {
      dgemm_("N", "N", &n, &n, &n, &one, A.data(), &n, B.data(), &n, &zero, C.data(), &n);
    }));
    benchmark::DoNotOptimize(C.data());
  }
  state.counters["megaflops_per_ms"] = 2e-6 * n * n * n / median(times);
}
BENCHMARK(dgemm)->Iterations(40);

}  // namespace
}  // namespace slammot::bench
