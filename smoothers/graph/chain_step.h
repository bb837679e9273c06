// One step of a landmark's chain, x' = f(x) + U G n.
//
// The noise of a motion in metres is an argument for a small world, as the camera's is
// (smoothers/scale/noise_scale.h). Where nothing but the first velocity tells the scale it is in
// units of the landmark's distance: U multiplies the rows of w by `unit` / rho(f(x)), where `unit`
// is rho where G was taken. Then n stays when the world grows. Elsewhere U is the identity.
#pragma once

#include "smoothers/graph/landmark.h"

namespace slammot {

// Of a motion at y: rho, but at least a hundredth of the stated mean [1/m]; 0: it is in metres.
double unit_of_motion(const GraphModels& models, const Eigen::Vector3d& y);

// x'
LandmarkVector advance(const GraphModels& models, const ChainStep& step, const LandmarkVector& x,
                       const LandmarkVector& noise);

// dx'/dx at n = step.noise.
LandmarkMatrix chain_jacobian(const GraphModels& models, const ChainStep& step,
                              const LandmarkVector& x);

// G := U G with U at x: the same step, and dx'/dn is G there.
void take_unit(const GraphModels& models, const LandmarkVector& x, ChainStep& step);

}  // namespace slammot
