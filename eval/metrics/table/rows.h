// The rows of the table of metrics, by what they are of.
#pragma once

#include "eval/metrics/metric.h"

namespace slammot {

MetricTable accuracy_rows();
MetricTable consistency_rows();
MetricTable label_rows();
MetricTable statement_rows();
MetricTable lag_rows();
MetricTable runtime_rows();

}  // namespace slammot
