// A frame of the window against one of the EKF on the same data, against its own length, and on a
// static world against its own converged solution.
#include <benchmark/benchmark.h>

#include <cmath>

#include "bench/corridor.h"
#include "bench/frame_times.h"

namespace slammot::bench {
namespace {

constexpr int kWarm = 150, kTimed = 100;  // frames

void report(benchmark::State& state, const FrameTimes& times) {
  state.SetIterationTime(1e-3 * times.median("total"));
  for (const auto& [stage, ms] : times.stages) state.counters[stage] = times.median(stage);
}

// Range: landmarks in view, length of the window.
void window_frame(benchmark::State& state) {
  const CorridorOptions options{.frames = kWarm + kTimed,
                                .visible = static_cast<int>(state.range(0))};
  const Corridor corridor = make_corridor(options);
  Configuration configuration = thesis_configuration(options);
  configuration.window.frames = static_cast<int>(state.range(1));
  for (auto _ : state) {
    const FrameTimes window =
        time_frames(corridor.setup, corridor.frames, "window", configuration, kWarm);
    const FrameTimes ekf =
        time_frames(corridor.setup, corridor.frames, "ekf", configuration, kWarm);
    report(state, window);
    state.counters["ekf"] = ekf.median("total");
    state.counters["ratio"] = window.median("total") / ekf.median("total");
  }
}
BENCHMARK(window_frame)
    ->Args({30, 5})
    ->Args({30, 10})
    ->Args({30, 20})
    ->Args({30, 40})
    ->Apply(one_pass);

// Of the camera's position over the timed frames [m].
double rmse(const Corridor& corridor, const FrameTimes& times) {
  const std::size_t warm = corridor.truth.size() - times.positions.size();
  double sum = 0.0;
  for (std::size_t i = 0; i < times.positions.size(); ++i) {
    sum += (times.positions[i] - corridor.truth[warm + i].position).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(times.positions.size()));
}

// Range: landmarks in view, all static and known to be so.
void static_window(benchmark::State& state) {
  const CorridorOptions options{.frames = kWarm + kTimed,
                                .visible = static_cast<int>(state.range(0)),
                                .moving_fraction = 0.0};
  const Corridor corridor = make_corridor(options);
  Configuration configuration = thesis_configuration(options);
  configuration.model.classifier.name = "all_static";
  configuration.model.labels.rule = LabelRule::kOneWay;
  configuration.model.labels.births = Births::kStaticFirst;
  Configuration converged =
      configuration;  // what any smoother of this model and graph converges to
  converged.window.iterations = 50;
  converged.window.linearisation_error = 1e-8;
  for (auto _ : state) {
    const FrameTimes times =
        time_frames(corridor.setup, corridor.frames, "window", configuration, kWarm);
    report(state, times);
    state.counters["rmse"] = rmse(corridor, times);
    state.counters["rmse_converged"] =
        rmse(corridor, time_frames(corridor.setup, corridor.frames, "window", converged, kWarm));
  }
}
BENCHMARK(static_window)->Arg(17)->Arg(30)->Apply(one_pass);

}  // namespace
}  // namespace slammot::bench
