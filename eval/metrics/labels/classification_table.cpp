#include "eval/metrics/labels/classification_table.h"

#include "eval/statistics/statistics.h"

namespace slammot {
namespace {

double ratio(int part, int whole) {
  return whole == 0 ? kUndefined : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

void ClassCounts::add(Label label, Label truth) {
  ++(label == truth ? right : label == Label::kUnknown ? undecided : wrong);
}

double ClassCounts::rightly_classified() const { return ratio(right, all()); }
double ClassCounts::wrongly_classified() const { return ratio(wrong, all()); }
double ClassCounts::misclassified() const { return ratio(wrong + undecided, all()); }

ClassificationMetrics classification_metrics(const std::vector<ClassificationRecord>& records) {
  ClassificationMetrics metrics;
  std::vector<double> frames_to_decision;
  for (const ClassificationRecord& record : records) {
    if (record.decision_frame) frames_to_decision.push_back(record.observations);
    if (!record.truth) {
      ++metrics.without_truth;
      continue;
    }
    ClassCounts& counts = *record.truth == Label::kStatic ? metrics.statics : metrics.movings;
    counts.add(record.label, *record.truth);
  }
  metrics.median_frames_to_decision = median(frames_to_decision);
  return metrics;
}

}  // namespace slammot
