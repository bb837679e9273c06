// Every parametrisation of a point: one entry adds one, to the table, to every landmark model and
// to the tests of models and estimators.
#pragma once

#include <tuple>

#include "models/points/homogeneous.h"
#include "models/points/inverse_depth.h"
#include "models/points/log_inverse_depth.h"
#include "models/points/xyz.h"

namespace slammot {

using PointParametrisations = std::tuple<InverseDepth, LogInverseDepth, Homogeneous, Xyz>;

}  // namespace slammot
