#include "eval/configuration/registry.h"

#include <stdexcept>

#include "filters/ekf.h"
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

void as_stated(Configuration&) {}
// Here and with true labels nothing is taken back.
void all_static(Configuration& c) {
  c.model.classifier.name = "all_static";
  c.model.labels.rule = LabelRule::kOneWay;
}
void true_labels(Configuration& c) {
  c.model.classifier.name = "truth";
  c.model.labels.rule = LabelRule::kOneWay;
}
// Covariances at the truth, with labels given and every measurement used: a probability of 1 opens
// the gate, so that nothing of P depends on the estimates. Its prior is the one that is stated.
void bound(Configuration& c) {
  true_labels(c);
  c.model.gate_probability = 1.0;
  c.ekf.linearisation = FilterLinearisation::kIdeal;
  c.model.depth_prior = DepthPriorSource::kFixed;
  c.prior.mean_sigma = 0.0;
}
void delayed(Configuration& c) { c.ekf.delayed = true; }

constexpr EstimatorRow kTable[] = {
    {"ekf", "extended Kalman filter, undelayed (the thesis)", as_stated, ekf},
    {"window", "sliding-window smoother with marginalisation", as_stated, window},
    {"batch", "all frames at once: the reference", as_stated, batch},
    {"static_world", "ekf, every landmark static", all_static, ekf},
    {"delayed", "ekf, a landmark counts only once it is classified", delayed, ekf},
    {"true_labels", "ekf, labels from the ground truth", true_labels, ekf},
    {"bound", "ekf linearised at the truth: the posterior Cramer-Rao bound", bound, ekf},
};

}  // namespace

std::span<const EstimatorRow> estimator_table() { return kTable; }

const EstimatorRow& find_estimator(const std::string& name) {
  std::string known;
  for (const EstimatorRow& row : kTable) {
    if (row.name == name) return row;
    known += (known.empty() ? "" : ", ") + std::string(row.name);
  }
  throw std::invalid_argument("unknown estimator '" + name + "', there are " + known);
}

}  // namespace slammot
