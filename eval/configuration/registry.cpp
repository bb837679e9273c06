#include "eval/configuration/registry.h"

#include <map>
#include <mutex>
#include <stdexcept>

#include "datasets/sequence/sha256.h"
#include "datasets/text/text_table.h"
#include "eval/python/python_estimator.h"
#include "filters/ekf.h"
#include "models/find_row.h"
#include "smoothers/batch.h"
#include "smoothers/window/window.h"

namespace slammot {
namespace {

std::unique_ptr<Estimator> ekf(const Setup& setup, const Configuration& c) {
  return make_ekf(setup, c.model, c.ekf);
}
std::unique_ptr<Estimator> window(const Setup& setup, const Configuration& c) {
  return make_window(setup, c.model, c.window);
}
std::unique_ptr<Estimator> batch(const Setup& setup, const Configuration& c) {
  return make_batch(setup, c.model, c.window);
}

constexpr const char* kTrueLabels = "truth";  // the classifier that is given the labels

void as_stated(Configuration&) {}
// Here and with true labels no label is reverted.
void all_static(Configuration& c) {
  c.model.classifier.name = "all_static";
  c.model.labels.rule = LabelRule::kOneWay;
}
void true_labels(Configuration& c) {
  c.model.classifier.name = kTrueLabels;
  c.model.labels.rule = LabelRule::kOneWay;
}
// Covariances at the truth, with labels given and every measurement used: a probability of 1 opens
// the gate, so that nothing of P depends on the estimates. Its prior is the stated one. This is no
// Cramer-Rao bound: docs/consistency-background.md says what it is.
void ideal_covariance(Configuration& c) {
  true_labels(c);
  c.model.gate = {1.0, 1.0};
  c.model.policy.movers = Movers::kJoint;
  c.ekf.linearisation = FilterLinearisation::kIdeal;
  c.model.depth_prior = DepthPriorSource::kFixed;
  c.prior.mean_sigma = 0.0;
}
void delayed(Configuration& c) { c.model.policy.delayed = true; }

using enum EstimatorKind;

EstimatorRow filter(const char* name, const char* description, bool oracle,
                    void (*adjust)(Configuration&), EstimatorKind kind = kFilter) {
  return {name, description, kind, oracle, adjust, ekf, true, "window."};
}

EstimatorRow smoother(const char* name, const char* description, EstimatorKind kind,
                      std::unique_ptr<Estimator> (*make)(const Setup&, const Configuration&)) {
  return {name, description, kind, false, as_stated, make, true, "ekf."};
}

std::vector<EstimatorRow>& table() {
  static std::vector<EstimatorRow> rows = {
      filter("ekf", "extended Kalman filter, undelayed (the thesis)", false, as_stated),
      smoother("window", "sliding-window smoother with marginalisation", kSmoother, window),
      smoother("batch", "all frames at once: the reference", kBatch, batch),
      filter("static_world", "ekf, every landmark static", false, all_static),
      filter("delayed", "ekf, a landmark counts only once it is classified", false, delayed),
      filter("true_labels", "ekf, labels from the ground truth", true, true_labels),
      filter("ideal_covariance",
             "ekf linearised at the truth, labels given, no gate: its covariance", true,
             ideal_covariance, kIdealCovariance),
  };
  return rows;
}

EstimatorRow python_row(const std::string& name, const PythonClass& python) {
  const PythonDescription said = describe(python);
  return {name,
          said.description,
          said.kind == to_string(kSmoother) ? kSmoother : kFilter,
          false,
          as_stated,
          [python](const Setup& setup, const Configuration& c) {
            return make_python_estimator(python, setup, c.python_options, key_values(c));
          },
          false};
}

// By name; a map, because references to its rows stay good.
const EstimatorRow& find_python(const std::string& name, const PythonClass& python) {
  static std::mutex mutex;
  static std::map<std::string, EstimatorRow> asked;
  const std::lock_guard lock(mutex);
  const auto found = asked.find(name);
  if (found != asked.end()) return found->second;
  return asked.emplace(name, python_row(name, python)).first->second;
}

// Smoothers cannot be.
bool linearised_at_the_truth(EstimatorKind kind, const Configuration& c) {
  const bool smooths = kind == kSmoother || kind == kBatch;
  return !smooths && c.ekf.linearisation == FilterLinearisation::kIdeal;
}

}  // namespace

std::string_view to_string(EstimatorKind kind) {
  constexpr std::string_view kNames[] = {"filter", "smoother", "batch", "ideal_covariance"};
  return kNames[static_cast<size_t>(kind)];
}

std::span<const EstimatorRow> estimator_table() { return table(); }

void add_estimators(std::span<const EstimatorRow> rows) { add_rows(table(), rows, "estimator"); }

const EstimatorRow& find_estimator(const std::string& name) {
  if (name == "bound") {
    throw std::invalid_argument(
        "estimator 'bound' is called 'ideal_covariance' now: it is no bound");
  }
  if (const auto python = python_class(name)) return find_python(name, *python);
  return find_row(estimator_table(), name, "estimator");
}

std::string estimator_label(const std::string& name) {
  const auto python = python_class(name);
  return python ? python->name : name;
}

bool is_batch(const std::string& name) {
  return std::ranges::any_of(estimator_table(), [&](const EstimatorRow& row) {
    return row.name == name && row.kind == EstimatorKind::kBatch;
  });
}

bool has_models(const std::string& name) {
  for (const EstimatorRow& row : estimator_table()) {
    if (row.name == name) return row.has_models;
  }
  return !name.starts_with(kPythonPrefix);
}

std::string estimator_sha256(const std::string& name) {
  const auto python = python_class(name);
  if (!python) return "";
  Sha256 hash;
  hash.add(read_text_file(python->file));
  return hash.hex();
}

bool is_oracle(const EstimatorRow& row, Configuration configuration) {
  row.adjust(configuration);
  return row.oracle || configuration.model.classifier.name == kTrueLabels ||
         linearised_at_the_truth(row.kind, configuration);
}

}  // namespace slammot
