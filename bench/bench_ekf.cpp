// A frame of the EKF against the bare symmetric rank-2m update of its covariance.
#include <benchmark/benchmark.h>

#include "bench/corridor.h"
#include "bench/frame_times.h"

namespace slammot::bench {
namespace {

// P := P - W W' on one triangle, n x n and n x k, with nothing around it.
class BareUpdate {
 public:
  double milliseconds(int n, int k) {
    const auto rows = static_cast<std::size_t>(n);
    W_.resize(rows * static_cast<std::size_t>(k), 1e-3);
    P_.resize(rows * rows, 1.0);
    const double minus = -1.0, one = 1.0;
    return bench::milliseconds(
        [&] { dsyrk_("L", "N", &n, &k, &minus, W_.data(), &n, &one, P_.data(), &n); });
  }

 private:
  std::vector<double> W_, P_;
};

// Frames from where the state has grown to `n` on, each beside a bare update of the same size.
void ekf_frame(benchmark::State& state) {
  const auto n = static_cast<int>(state.range(0));
  const CorridorOptions options{.frames = 100 + n};
  const Corridor corridor = make_corridor(options);
  const Configuration configuration = thesis_configuration(options);
  const auto ekf = find_estimator("ekf").make(corridor.setup, configuration);
  std::size_t next = 0;
  FrameTimes warm, times;
  for (int size = 0; size < n && next < corridor.frames.size();) {
    time_frame(*ekf, corridor.frames[next++], warm);
    size = warm.reports.back().state_size;
  }
  BareUpdate bare;
  std::vector<double> update, ratio, measured, size;
  for (auto _ : state) {
    if (next == corridor.frames.size()) {
      state.SkipWithError("the corridor is too short for this state");
      return;
    }
    time_frame(*ekf, corridor.frames[next++], times);
    const FrameReport& report = times.reports.back();
    const double total = times.stages.at("total").back();
    state.SetIterationTime(1e-3 * total);
    measured.push_back(report.accepted);
    size.push_back(report.state_size);
    update.push_back(bare.milliseconds(report.state_size, 2 * report.accepted));
    ratio.push_back(total / update.back());
  }
  for (const auto& [stage, ms] : times.stages) state.counters[stage] = median(ms);
  state.counters["n"] = median(size);
  state.counters["m"] = median(measured);
  state.counters["dsyrk"] = median(update);
  state.counters["ratio"] = median(ratio);
}
BENCHMARK(ekf_frame)
    ->Arg(300)
    ->Arg(600)
    ->Arg(1000)
    ->Arg(2000)
    ->Arg(3000)
    ->Iterations(40)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace slammot::bench
