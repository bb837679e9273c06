// The 2 x 3 table of true class against label, and the thesis's two error ratios (section 4.1.1):
//   wrongly classified  labelled the other class;
//   misclassified       wrongly classified, or left unknown.
// Counted are landmarks that had to be classified and whose truth is known.
#pragma once

#include <vector>

#include "eval/result/run_result.h"

namespace slammot {

struct ClassCounts {
  int right = 0;
  int wrong = 0;
  int undecided = 0;

  void add(Label label, Label truth);
  int all() const { return right + wrong + undecided; }
  double rightly_classified() const;  // ratios; NaN of no landmarks
  double wrongly_classified() const;
  double misclassified() const;
};

struct ClassificationMetrics {
  ClassCounts statics;  // landmarks that truly are static
  ClassCounts movings;
  int without_truth = 0;
  double median_frames_to_decision = 0.0;  // frames in which the landmark was measured until then
};

ClassificationMetrics classification_metrics(const std::vector<ClassificationRecord>& records);

}  // namespace slammot
