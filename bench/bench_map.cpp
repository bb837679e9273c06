// The cost of a frame against the number of landmarks in the map, 30 of them in view. `large_map`,
// 2000 of them, takes minutes to build, and is no part of scripts/bench.
#include <benchmark/benchmark.h>

#include "bench/corridor.h"
#include "bench/frame_times.h"

namespace slammot::bench {
namespace {

void map_size(benchmark::State& state, const std::string& estimator) {
  const auto landmarks = static_cast<std::size_t>(state.range(0));
  constexpr std::size_t kTimed = 40;
  const CorridorOptions options{
      .frames = 200 + 3 * static_cast<int>(landmarks), .visible = 30, .speed = 6.0};
  const Corridor corridor = make_corridor(options);
  const Configuration configuration = thesis_configuration(options);
  const auto made = find_estimator(estimator).make(corridor.setup, configuration);
  FrameTimes warm, times;
  std::size_t next = 0;
  for (std::size_t size = 0; size < landmarks && next < corridor.frames.size(); ++next) {
    time_frame(*made, corridor.frames[next], warm);
    if (next % 8 == 0) size = made->landmarks().size();
  }
  for (auto _ : state) {
    if (next + kTimed > corridor.frames.size()) {
      state.SkipWithError("the corridor is too short for this map");
      return;
    }
    for (std::size_t i = 0; i < kTimed; ++i) time_frame(*made, corridor.frames[next++], times);
    state.SetIterationTime(1e-3 * times.mean("total"));  // folds are rare and long
    state.counters["n"] = times.reports.front().state_size;
    state.counters["total"] = times.mean("total");
  }
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  for (const int landmarks : {50, 100, 200, 500, 1000}) benchmark->Arg(landmarks);
  one_pass(benchmark);
}
BENCHMARK_CAPTURE(map_size, ekf, "ekf")->Apply(sizes);
BENCHMARK_CAPTURE(map_size, window, "window")->Apply(sizes);

void large_map(benchmark::State& state, const std::string& estimator) {
  map_size(state, estimator);
}
BENCHMARK_CAPTURE(large_map, ekf, "ekf")->Arg(2000)->Apply(one_pass);
BENCHMARK_CAPTURE(large_map, window, "window")->Arg(2000)->Apply(one_pass);

}  // namespace
}  // namespace slammot::bench
