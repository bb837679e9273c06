// The table of estimators: the one place that knows which there are. One row adds one. Beside them
// stand those written in Python, by the name `python:FILE.py:Class`.
#pragma once

#include <functional>
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
  std::string name;
  std::string description;
  EstimatorKind kind;
  bool oracle;  // given part of the ground truth, whatever the configuration
  std::function<void(Configuration&)> adjust;  // what the name means beyond the factory
  std::function<std::unique_ptr<Estimator>(const Setup&, const Configuration&)> make;
  bool has_models = true;        // false: landmark models mean nothing to it
  std::string_view unread = {};  // how the names of the keys begin that it never reads
};

std::span<const EstimatorRow> estimator_table();

// Before anything is looked up; throws std::invalid_argument for a name that is taken.
void add_estimators(std::span<const EstimatorRow> rows);

// Throws std::invalid_argument naming the known ones, or saying what is wrong with a script. What
// a script says of itself is asked once.
const EstimatorRow& find_estimator(const std::string& name);

// The name in labels and names of folders: of a Python estimator its class.
std::string estimator_label(const std::string& name);

// Whether it is a batch; of a name that a stored run states: a script is none.
bool is_batch(const std::string& name);

// EstimatorRow::has_models, of a name that a stored run states: a script is not asked, and a name
// need not be known.
bool has_models(const std::string& name);

// SHA-256 of a Python estimator's file, which a result depends on; empty for the others.
std::string estimator_sha256(const std::string& name);

// Whether it is given part of the ground truth: labels, or the point of linearisation.
bool is_oracle(const EstimatorRow& row, Configuration configuration);

}  // namespace slammot
