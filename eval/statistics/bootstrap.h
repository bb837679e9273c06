// Percentile bootstrap over runs (Efron & Tibshirani 1993): the runs are independent, the frames
// and the landmarks of one run are not, so runs are resampled.
#pragma once

#include <functional>
#include <vector>

namespace slammot {

struct Estimate {
  double value = 0.0;
  double lower = 0.0;  // two-sided 95%; undefined for fewer than two samples
  double upper = 0.0;
  int samples = 0;
};

using Statistic = std::function<double(const std::vector<double>&)>;

// 2000 resamples from a fixed seed: the same samples give the same interval.
Estimate bootstrap(const std::vector<double>& samples, const Statistic& statistic);

// What one run adds to a mean over the samples of all runs.
struct RunSum {
  double sum = 0.0;
  double count = 0.0;
};

// Sum over count, of runs that weigh as many samples as they have. A resample without any sample is
// left out; undefined when no run has one.
Estimate bootstrap_mean(const std::vector<RunSum>& runs);

}  // namespace slammot
