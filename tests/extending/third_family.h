// The worked example of a third estimator family: its row, as a registry would have it.
#pragma once

#include "eval/configuration/registry.h"

namespace slammot {

extern const EstimatorRow kUnscented;

}  // namespace slammot
