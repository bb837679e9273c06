// The table of metrics: the program's rows, and a caller's own.
#include "eval/metrics/table/row_forms.h"
#include "eval/metrics/table/rows.h"

namespace slammot {
namespace {

MetricTable all_rows() {
  MetricTable table = accuracy_rows();
  append(table, consistency_rows());
  append(table, label_rows());
  append(table, statement_rows());
  append(table, lag_rows());
  append(table, runtime_rows());
  return table;
}

MetricTable& program_table() {
  static MetricTable table = all_rows();
  return table;
}

}  // namespace

const MetricTable& metric_table() { return program_table(); }

void add_metrics(const MetricTable& more) {
  for (const Metric& added : more) {
    for (const Metric& metric : metric_table()) {
      if (metric.key != added.key) continue;
      throw std::invalid_argument("there is a metric '" + added.key + "' already");
    }
    program_table().push_back(added);
  }
}

MetricTable metric_table_with(const MetricTable& more) {
  MetricTable table = metric_table();
  append(table, more);
  return table;
}

double value_of(const std::vector<MetricValue>& values, const std::string& key) {
  for (const MetricValue& v : values) {
    if (v.metric.key == key) return v.value;
  }
  return kUndefined;
}

}  // namespace slammot
