// Runs side by side as one aligned text table; `-` where a metric is not known.
#pragma once

#include <string>
#include <vector>

#include "eval/compare/compare.h"

namespace slammot {

std::string metrics_table(const std::vector<ComparedResult>& results);

}  // namespace slammot
