// Numbers and intervals in the JSON of studies, where null is what is not defined.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "estimation/estimator.h"
#include "eval/metrics/metric.h"
#include "eval/statistics/bootstrap.h"
#include "eval/statistics/statistics.h"

namespace slammot {

inline double number(const nlohmann::ordered_json& json) {
  return json.is_number() ? json.get<double>() : kUndefined;
}

inline nlohmann::ordered_json json_of(const Estimate& e) {
  return {{"value", e.value}, {"lower", e.lower}, {"upper", e.upper}, {"runs", e.samples}};
}

// The runs' values of a metric put together, as its row says.
inline Estimate pool(const std::vector<double>& samples, Pooled how) {
  return bootstrap(samples, how == Pooled::kRootMeanSquare ? root_mean_square : mean);
}

// Sum and count of a mean NEES over `count` samples. One that is null over some samples was
// infinite: a covariance was not positive definite.
inline RunSum run_sum(const nlohmann::ordered_json& mean, const nlohmann::ordered_json& count) {
  const double n = number(count);
  if (n == 0.0) return {};
  return {mean.is_number() ? n * number(mean) : INFINITY, n};
}

}  // namespace slammot
