// How landmarks were labelled.
#include "eval/metrics/table/row_forms.h"
#include "eval/metrics/table/rows.h"

namespace slammot {
namespace {

MetricTable class_rows(const std::string& truth, ClassCounts ClassificationMetrics::*counts) {
  const auto row = [&](const char* leaf, const char* caption, auto member) {
    const auto value = [=](const FinishedRun& f) {
      return number(member, f.metrics.classification.*counts);
    };
    return detail("classification." + truth, leaf, caption, value);
  };
  const auto ratio = [](Metric m, Better better) {
    m.form = Form::kRatio;
    m.better = better;
    return m;
  };
  using C = ClassCounts;
  Metric right = on_page(ratio(
      row("rightly_classified", "labelled as they are", &C::rightly_classified), Better::kLarger));
  right.name = truth + " right";
  return {count(row("right", "labelled as they are", &C::right)),
          count(row("wrong", "labelled the other class", &C::wrong)),
          count(row("undecided", "left unknown", &C::undecided)),
          right,
          ratio(row("wrongly_classified", "labelled the other class", &C::wrongly_classified),
                Better::kSmaller),
          ratio(row("misclassified", "labelled the other class or left unknown (thesis 4.1.1)",
                    &C::misclassified),
                Better::kSmaller)};
}

MetricTable classification_rows() {
  using C = ClassificationMetrics;
  const auto of = [](auto member) {
    return [=](const FinishedRun& f) { return number(member, f.metrics.classification); };
  };
  return {
      count(detail("classification", "without_truth",
                   "classified landmarks whose true class is not known", of(&C::without_truth))),
      {.key = "median_frames_to_decision",
       .unit = "frames",
       .name = "frames to decision",
       .caption = "median number of measurements until a label is decided",
       .value = of(&C::median_frames_to_decision),
       .decimals = 1,
       .block = "classification"}};
}

}  // namespace

MetricTable label_rows() {
  MetricTable table = class_rows("static", &ClassificationMetrics::statics);
  append(table, class_rows("moving", &ClassificationMetrics::movings));
  append(table, classification_rows());
  return table;
}

}  // namespace slammot
