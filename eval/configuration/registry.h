// The table of estimators: the one place that knows which there are. One row adds one.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "estimation/estimator.h"
#include "eval/configuration/configuration.h"

namespace slammot {

// What an estimator is, and so what it is compared with. An ideal covariance is what others are
// measured against: it takes part in no comparison.
enum class EstimatorKind { kFilter, kSmoother, kBatch, kIdealCovariance };

std::string_view to_string(EstimatorKind kind);

struct EstimatorRow {
  std::string_view name;
  std::string_view description;
  EstimatorKind kind;
  bool oracle;                     // given part of the ground truth, whatever the configuration
  void (*adjust)(Configuration&);  // what the name means beyond the factory, stated in run.yaml
  std::unique_ptr<Estimator> (*make)(const Setup&, const Configuration&);
};

std::span<const EstimatorRow> estimator_table();

// Throws std::invalid_argument naming the known ones.
const EstimatorRow& find_estimator(const std::string& name);

// Whether it is given part of the ground truth: labels, or the point of linearisation.
bool is_oracle(const EstimatorRow& row, Configuration configuration);

}  // namespace slammot
