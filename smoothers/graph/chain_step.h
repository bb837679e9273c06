// What is assumed of a landmark's motion: the prior of w, and a step of its chain,
//
//   r = rho(y) w / (unit sigma),   x' = f(x) + U G n.
//
// Of a motion in metres both are arguments for a small world, as the camera's noise is
// (smoothers/scale/noise_scale.h). Where nothing but the first velocity tells the scale they are in
// units of the landmark's distance: `unit` is rho where sigma was stated, or G taken, and U
// multiplies the rows of w by unit / rho(f(x)). Then r and n stay when the world grows. Elsewhere r
// is w / sigma, and U the identity. (U leaves the rows of y alone: in depth no pixel tells n.)
#pragma once

#include "smoothers/graph/landmark.h"

namespace slammot {

// Of a motion at y: rho, but at least a hundredth of the stated mean [1/m]; 0: it is in metres.
double unit_of_motion(const GraphModels& models, const Eigen::Vector3d& y);

MotionVector motion_residual(const GraphModels& models, const MotionPrior& prior,
                             const Eigen::Vector3d& y, const MotionVector& w);
// Fills in r, J_y and J_w there.
void linearise_motion_prior(const GraphModels& models, const Eigen::Vector3d& y,
                            const MotionVector& w, MotionPrior& prior);

// x'
LandmarkVector advance(const GraphModels& models, const ChainStep& step, const LandmarkVector& x,
                       const LandmarkVector& noise);

// dx'/dx
LandmarkMatrix chain_jacobian(const GraphModels& models, const ChainStep& step,
                              const LandmarkVector& x, const LandmarkVector& noise);

// U G = dx'/dn.
LandmarkMatrix noise_jacobian(const GraphModels& models, const ChainStep& step,
                              const LandmarkVector& x);

// G := U G with U at x: the same step, and dx'/dn is G there.
void take_unit(const GraphModels& models, const LandmarkVector& x, ChainStep& step);

}  // namespace slammot
