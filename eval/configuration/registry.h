// The table of estimators: the one place that knows which there are. One row adds one.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "estimation/estimator.h"
#include "eval/configuration/configuration.h"

namespace slammot {

struct EstimatorRow {
  std::string_view name;
  std::string_view description;
  void (*adjust)(Configuration&);  // what the name means beyond the factory, stated in run.yaml
  std::unique_ptr<Estimator> (*make)(const Setup&, const Configuration&);
};

std::span<const EstimatorRow> estimator_table();

// Throws std::invalid_argument naming the known ones.
const EstimatorRow& find_estimator(const std::string& name);

}  // namespace slammot
