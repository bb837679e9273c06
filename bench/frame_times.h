// The stages of an estimator's frames, timed.
#pragma once

#include <benchmark/benchmark.h>

#include <map>
#include <string>
#include <vector>

#include "bench/timing.h"
#include "eval/configuration/registry.h"
#include "eval/run/stage_clock.h"

namespace slammot::bench {

// Milliseconds of each stage, `total` among them, frame by frame; 0 where a frame has no such
// stage.
struct FrameTimes {
  std::map<std::string, std::vector<double>> stages;
  std::vector<FrameReport> reports;
  std::vector<Eigen::Vector3d> positions;  // of the camera, as estimated after each frame

  double median(const std::string& stage) const { return bench::median(stages.at(stage)); }
  double mean(const std::string& stage) const {
    double sum = 0.0;
    for (const double ms : stages.at(stage)) sum += ms;
    return sum / static_cast<double>(stages.at(stage).size());
  }
};

// One frame more; the estimator's answer is kept.
inline void time_frame(Estimator& estimator, const Frame& frame, FrameTimes& times) {
  StageClock clock;
  times.reports.push_back(estimator.process(frame, clock));
  for (const auto& [stage, ms] : clock.finish()) times.stages[stage].push_back(ms);
  times.positions.push_back(estimator.camera().state.position);
}

// Frames from number `first` on; those before only warm up.
inline FrameTimes time_frames(const Setup& setup, const std::vector<Frame>& frames,
                              const std::string& estimator, const Configuration& configuration,
                              std::size_t first) {
  const auto made = find_estimator(estimator).make(setup, configuration);
  FrameTimes warm, times;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    time_frame(*made, frames[i], i < first ? warm : times);
  }
  return times;
}

// How the benchmarks here are run: they time frames themselves, in one pass.
inline void one_pass(benchmark::internal::Benchmark* benchmark) {
  benchmark->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
}

}  // namespace slammot::bench
