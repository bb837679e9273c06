// Numbers and intervals in the JSON of studies, where null is what is not defined.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "estimation/estimator.h"
#include "eval/metrics/metric.h"
#include "eval/output/metrics_json.h"
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

// A NEES, or a mean of some. One that is null was infinite: a covariance was not positive definite.
// Throws a JSON error where it is negative.
inline double nees_number(const nlohmann::ordered_json& json) {
  const double nees = number(json);
  if (nees < 0.0) {
    throw nlohmann::ordered_json::other_error::create(501, "a NEES is negative", &json);
  }
  return std::isnan(nees) ? INFINITY : nees;
}

// Sum and count of a mean NEES over `count` samples.
inline RunSum run_sum(const nlohmann::ordered_json& mean, const nlohmann::ordered_json& count) {
  const double n = count_of(count);
  if (n == 0.0) return {};
  return {n * nees_number(mean), n};
}

}  // namespace slammot
