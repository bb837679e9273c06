// A frame of the EKF against the bare symmetric rank-2m update of its covariance.
#include <benchmark/benchmark.h>

#include "slammot/bench/corridor.h"
#include "slammot/bench/timing.h"
#include "slammot/eval/registry.h"
#include "slammot/eval/stage_clock.h"

extern "C" void openblas_set_num_threads(int);

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
  openblas_set_num_threads(1);
  const auto n = static_cast<int>(state.range(0));
  const CorridorOptions options{.frames = 100 + 2 * n / 2};
  const Corridor corridor = make_corridor(options);
  const Configuration configuration = corridor_configuration(options);
  const auto ekf = find_estimator("ekf").make(corridor.setup, configuration);
  std::size_t next = 0;
  FrameReport report;
  for (; report.state_size < n && next < corridor.frames.size(); ++next) {
    StageClock clock;
    report = ekf->process(corridor.frames[next], clock);
  }
  BareUpdate bare;
  std::vector<double> frame, update, ratio, measured, size;
  std::map<std::string, std::vector<double>> stages;
  for (auto _ : state) {
    if (next == corridor.frames.size()) break;
    StageClock clock;
    report = ekf->process(corridor.frames[next++], clock);
    for (const auto& [stage, ms] : clock.finish()) stages[stage].push_back(ms);
    frame.push_back(stages["total"].back());
    state.SetIterationTime(1e-3 * frame.back());
    measured.push_back(report.accepted + report.rejected);
    size.push_back(report.state_size);
    update.push_back(bare.milliseconds(report.state_size, 2 * (report.accepted + report.rejected)));
    ratio.push_back(frame.back() / update.back());
  }
  if (frame.empty()) return state.SkipWithError("the corridor is too short for this state");
  for (const auto& [stage, ms] : stages) state.counters[stage] = median(ms);
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
    ->Iterations(60)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace slammot::bench
