#include "eval/statistics/run_nees.h"

#include <algorithm>
#include <cmath>

#include "eval/statistics/chi_square.h"
#include "eval/statistics/statistics.h"

namespace slammot {

double effective_samples(std::vector<double> series) {
  const auto n = series.size();
  double largest = 0.0;  // their squares shall not overflow
  for (const double x : series) largest = std::max(largest, std::abs(x));
  if (largest > 0.0) {
    for (double& x : series) x /= largest;
  }
  const double m = mean(series);
  const auto autocovariance = [&](std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i + lag < n; ++i) sum += (series[i] - m) * (series[i + lag] - m);
    return sum;
  };
  const double variance = n > 0 ? autocovariance(0) : 0.0;
  if (!(variance > 0.0)) return static_cast<double>(n);
  double correlations = -0.5;
  for (std::size_t lag = 0; lag + 1 < n; lag += 2) {
    const double pair = (autocovariance(lag) + autocovariance(lag + 1)) / variance;
    if (pair <= 0.0) break;
    correlations += pair;
  }
  const auto count = static_cast<double>(n);
  // Those that alternate are not worth more than independent ones.
  return std::max(count / std::max(2.0 * correlations, 1.0), 1.0);
}

RunNees run_nees(const std::vector<double>& series, int dof, double probability) {
  const auto infinite = std::ranges::find(series, INFINITY);
  if (infinite != series.end()) {
    const auto at = static_cast<std::size_t>(infinite - series.begin());
    return {INFINITY, static_cast<double>(dof), at};
  }
  std::vector<double> finite;
  std::vector<std::size_t> at;
  for (std::size_t i = 0; i < series.size(); ++i) {
    if (!std::isfinite(series[i])) continue;
    finite.push_back(series[i]);
    at.push_back(i);
  }
  RunNees result{mean(finite), NAN, {}};
  if (finite.empty()) return result;
  const double samples = effective_samples(finite);
  result.allowed = chi_square_quantile(probability, dof * samples) / samples;
  if (!result.exceeds()) return result;
  double sum = 0.0, largest = 0.0;
  std::size_t zero = 0;
  for (std::size_t i = 0; i < finite.size(); ++i) {
    sum += finite[i] - 2.0 * dof;
    if (sum <= 0.0) {
      sum = 0.0;
      zero = i + 1;
    }
    if (sum > largest) {
      largest = sum;
      result.began = at[zero];
    }
  }
  return result;
}

}  // namespace slammot
