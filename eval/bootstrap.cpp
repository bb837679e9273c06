#include "slammot/eval/bootstrap.h"

#include "slammot/datasets/random_stream.h"
#include "slammot/eval/statistics.h"
#include "slammot/models/estimator.h"

namespace slammot {

Estimate bootstrap(const std::vector<double>& samples, const Statistic& statistic) {
  constexpr int kDrawings = 2000;
  const int n = static_cast<int>(samples.size());
  Estimate estimate{statistic(samples), kUndefined, kUndefined, n};
  if (n < 2) return estimate;
  RandomStream random(1, "bootstrap");
  std::vector<double> values, drawn(samples.size());
  for (int i = 0; i < kDrawings; ++i) {
    for (double& x : drawn) x = samples[static_cast<std::size_t>(random.below(n))];
    values.push_back(statistic(drawn));
  }
  estimate.lower = quantile(values, 0.025);
  estimate.upper = quantile(values, 0.975);
  return estimate;
}

}  // namespace slammot
