// Every model of a landmark that may move, with its position in the parametrisation P: one entry
// adds one, to the table and to the tests of models and estimators.
#pragma once

#include <tuple>

#include "models/landmarks/constant_acceleration.h"
#include "models/landmarks/dynamic_inverse_depth.h"
#include "models/landmarks/scaled_velocity.h"

namespace slammot {

template <PointParametrisation P>
using LandmarkModels =
    std::tuple<DynamicInverseDepth<P>, ScaledVelocity<P>, ConstantAcceleration<P>>;

}  // namespace slammot
