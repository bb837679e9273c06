#include "estimation/label_policy.h"

#include <cmath>
#include <numeric>

namespace slammot {

namespace {

bool reversible(const LabelOptions& options) { return options.rule == LabelRule::kReversible; }

}  // namespace

bool watches_innovations(const LabelOptions& options) { return reversible(options); }

bool is_asked(const TrackRecord& record, const LabelOptions& options) {
  return record.label == Label::kUnknown || (reversible(options) && record.label == Label::kMoving);
}

void note_answer(TrackRecord& record, Label answer, int frame) {
  if (record.label == Label::kMoving && answer != Label::kStatic) return;
  note_decision(record, answer, frame);
}

void note_innovation(TrackRecord& record, double nis, const LabelOptions& options) {
  if (!reversible(options) || record.label != Label::kStatic || record.known) return;
  std::vector<double>& kept = record.static_nis;
  kept.reserve(static_cast<std::size_t>(options.window));
  if (std::ssize(kept) == options.window) kept.erase(kept.begin());
  kept.push_back(nis);
}

bool is_rejected(const TrackRecord& record, const LabelOptions& options) {
  const auto n = static_cast<int>(record.static_nis.size());
  if (n < 2) return false;  // a single outlier is the gate's business
  const double sum = std::accumulate(record.static_nis.begin(), record.static_nis.end(), 0.0);
  return chi_square_tail(sum, n) < options.probability;
}

void note_reverted(TrackRecord& record) {
  record.label = Label::kUnknown;
  record.decision_frame.reset();
  record.rejected_in_row = 0;
  record.static_nis.clear();
}

double chi_square_tail(double x, int n) {
  double term = std::exp(-0.5 * x), sum = 0.0;
  for (int k = 0; k < n; ++k) {
    sum += term;
    term *= 0.5 * x / (k + 1);
  }
  return sum;
}

}  // namespace slammot
