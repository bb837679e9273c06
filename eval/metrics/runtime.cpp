#include "eval/metrics/runtime.h"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

struct StageSamples {
  std::string stage;
  std::vector<double> milliseconds;
};

std::vector<double>& samples_of(std::vector<StageSamples>& all, const std::string& stage) {
  for (StageSamples& samples : all) {
    if (samples.stage == stage) return samples.milliseconds;
  }
  return all.emplace_back(StageSamples{stage, {}}).milliseconds;
}

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

}  // namespace

RuntimeMetrics runtime_metrics(const std::vector<StageTime>& timing, double smoothing_ms,
                               bool batch) {
  RuntimeMetrics metrics;
  std::vector<StageSamples> stages;
  std::vector<double> frames, sizes;
  for (const StageTime& time : timing) {
    samples_of(stages, time.stage).push_back(time.milliseconds);
    if (time.stage != "total") continue;
    frames.push_back(time.milliseconds);
    sizes.push_back(time.state_size);
  }
  std::stable_partition(stages.begin(), stages.end(),
                        [](const StageSamples& s) { return s.stage != "total"; });
  for (const StageSamples& s : stages) {
    metrics.stages.push_back(
        {s.stage, median(s.milliseconds), quantile(s.milliseconds, 0.95), sum(s.milliseconds)});
  }
  const double frame_count = static_cast<double>(frames.size());
  metrics.frame_median_ms = median(frames);
  if (batch && !frames.empty()) {
    const double share = smoothing_ms / frame_count;
    metrics.frame_median_ms += share;
    metrics.stages.insert(std::prev(metrics.stages.end()),
                          {"solution", share, share, smoothing_ms});
  }
  metrics.frame_p95_ms = quantile(frames, 0.95);
  metrics.smoothing_ms = smoothing_ms;
  const double all_ms = sum(frames) + smoothing_ms;
  metrics.frames_per_second = all_ms > 0.0 ? 1e3 * frame_count / all_ms : kUndefined;
  metrics.state_size_median = median(sizes);
  metrics.state_size_max = maximum(sizes);
  return metrics;
}

}  // namespace slammot
