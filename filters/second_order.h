// What the linearisation of h leaves out. The ray R' (rho (a - r) + G) contains the product of two
// uncertain quantities: with errors e of rho and d of a - r, the term e d.
//
// At the first frames of a camera that is predicted to stand still, a - r is zero. There the EKF
// takes the parallax per metre of every new landmark to be rho0, exactly, and tells a translation
// from a rotation by it. The second-order filter (Athans, Wishner & Bertolini 1968) states the
// covariance of the product as noise of the measurement. For Gaussian e and d of covariance c:
//
//     Cov(e d) = P_rho P_d + c c'        N = J Cov(e d) J',   J = d pixel / d ray (W)
//
// Of static landmarks only: the motion of a free one explains its parallax whatever rho is. The
// mean of the product, c, is left out. Figures: docs/recordings.md.
#pragma once

#include "models/points/observation.h"

namespace slammot {

// The covariance of camera position r, anchor a and y of a landmark, in this order.
using PositionsCovariance = Eigen::Matrix<double, 9, 9>;

// N [px^2] of a static landmark at y that is expected at h.
Eigen::Matrix2d second_order_noise(const PointFunctions& point, const Eigen::Vector3d& y,
                                   const PositionsCovariance& P, const ObservedPixel& h);

}  // namespace slammot
