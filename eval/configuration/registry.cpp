#include "eval/configuration/registry.h"

#include <stdexcept>

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
  c.ekf.linearisation = FilterLinearisation::kIdeal;
  c.model.depth_prior = DepthPriorSource::kFixed;
  c.prior.mean_sigma = 0.0;
}
void delayed(Configuration& c) { c.ekf.delayed = true; }

using enum EstimatorKind;

constexpr EstimatorRow kTable[] = {
    {"ekf", "extended Kalman filter, undelayed (the thesis)", kFilter, false, as_stated, ekf},
    {"window", "sliding-window smoother with marginalisation", kSmoother, false, as_stated, window},
    {"batch", "all frames at once: the reference", kBatch, false, as_stated, batch},
    {"static_world", "ekf, every landmark static", kFilter, false, all_static, ekf},
    {"delayed", "ekf, a landmark counts only once it is classified", kFilter, false, delayed, ekf},
    {"true_labels", "ekf, labels from the ground truth", kFilter, true, true_labels, ekf},
    {"ideal_covariance", "ekf linearised at the truth, labels given, no gate: its covariance",
     kIdealCovariance, true, ideal_covariance, ekf},
};

// The options that estimators of this kind have.
bool linearised_at_the_truth(EstimatorKind kind, const Configuration& c) {
  const bool smooths = kind == kSmoother || kind == kBatch;
  return smooths ? c.window.linearisation == WindowLinearisation::kIdeal
                 : c.ekf.linearisation == FilterLinearisation::kIdeal;
}

}  // namespace

std::string_view to_string(EstimatorKind kind) {
  constexpr std::string_view kNames[] = {"filter", "smoother", "batch", "ideal_covariance"};
  return kNames[static_cast<size_t>(kind)];
}

std::span<const EstimatorRow> estimator_table() { return kTable; }

const EstimatorRow& find_estimator(const std::string& name) {
  if (name == "bound") {
    throw std::invalid_argument(
        "estimator 'bound' is called 'ideal_covariance' now: it is no bound");
  }
  return find_row(estimator_table(), name, "estimator");
}

bool is_oracle(const EstimatorRow& row, Configuration configuration) {
  row.adjust(configuration);
  return row.oracle || configuration.model.classifier.name == kTrueLabels ||
         linearised_at_the_truth(row.kind, configuration);
}

}  // namespace slammot
