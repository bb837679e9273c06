#include "eval/statistics/bootstrap.h"

#include <map>

#include "datasets/simulation/scene/random_stream.h"
#include "estimation/estimator.h"
#include "eval/statistics/statistics.h"

namespace slammot {

namespace {

constexpr int kResamples = 2000;

// The runs of every resample, of n each. Made once for each n: thousands of frames use the same.
const std::vector<int>& resamples(int n) {
  thread_local std::map<int, std::vector<int>> made;
  std::vector<int>& runs = made[n];
  if (!runs.empty()) return runs;
  RandomStream random(1, "bootstrap");
  runs.reserve(static_cast<std::size_t>(kResamples) * static_cast<std::size_t>(n));
  for (int i = 0; i < kResamples * n; ++i) runs.push_back(random.below(n));
  return runs;
}

Estimate with_interval(Estimate estimate, const std::vector<double>& values) {
  estimate.lower = quantile(values, 0.025);
  estimate.upper = quantile(values, 0.975);
  return estimate;
}

}  // namespace

Estimate bootstrap(const std::vector<double>& samples, const Statistic& statistic) {
  const int n = static_cast<int>(samples.size());
  const Estimate estimate{statistic(samples), kUndefined, kUndefined, n};
  if (n < 2) return estimate;
  std::vector<double> values, resampled(samples.size());
  auto run = resamples(n).begin();
  for (int i = 0; i < kResamples; ++i) {
    for (double& x : resampled) x = samples[static_cast<std::size_t>(*run++)];
    values.push_back(statistic(resampled));
  }
  return with_interval(estimate, values);
}

Estimate bootstrap_mean(const std::vector<RunSum>& runs) {
  const int n = static_cast<int>(runs.size());
  RunSum all;
  for (const RunSum& r : runs) all = {all.sum + r.sum, all.count + r.count};
  if (all.count == 0.0) return {kUndefined, kUndefined, kUndefined, 0};
  const Estimate estimate{all.sum / all.count, kUndefined, kUndefined, n};
  if (n < 2) return estimate;
  std::vector<double> values;
  auto run = resamples(n).begin();
  for (int i = 0; i < kResamples; ++i) {
    RunSum resampled;
    for (int k = 0; k < n; ++k) {
      const RunSum& r = runs[static_cast<std::size_t>(*run++)];
      resampled = {resampled.sum + r.sum, resampled.count + r.count};
    }
    if (resampled.count > 0.0) values.push_back(resampled.sum / resampled.count);
  }
  return with_interval(estimate, values);
}

}  // namespace slammot
