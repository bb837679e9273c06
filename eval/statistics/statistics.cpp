#include "eval/statistics/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slammot {
namespace {
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
}

double mean(const std::vector<double>& samples) {
  if (samples.empty()) return kNothing;
  double sum = 0.0;
  for (const double x : samples) sum += x;
  return sum / static_cast<double>(samples.size());
}

double root_mean_square(const std::vector<double>& samples) {
  if (samples.empty()) return kNothing;
  double sum = 0.0;
  for (const double x : samples) sum += x * x;
  return std::sqrt(sum / static_cast<double>(samples.size()));
}

double maximum(const std::vector<double>& samples) {
  return samples.empty() ? kNothing : *std::max_element(samples.begin(), samples.end());
}

double quantile(std::vector<double> samples, double p) {
  if (samples.empty()) return kNothing;
  std::sort(samples.begin(), samples.end());
  const double place = p * static_cast<double>(samples.size() - 1);
  const size_t below = static_cast<size_t>(place);
  const double fraction = place - static_cast<double>(below);
  // Equal neighbours are returned as they are: both may be infinite.
  if (fraction == 0.0 || samples[below] == samples[below + 1]) return samples[below];
  return samples[below] + fraction * (samples[below + 1] - samples[below]);
}

}  // namespace slammot
