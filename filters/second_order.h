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
// The products of two landmarks i and j have the camera in common, and the error of the mean depth
// if that is estimated. So N has blocks beside its diagonal:
//
//     Cov(e_i d_i, e_j d_j) = E[e_i e_j] E[d_i d_j'] + E[d_i e_j] E[e_i d_j']
//
// Without them many landmarks seem to know a translation that known ones contradict, and these are
// rejected. They are stated once a known landmark has been measured, and with a rig or depths.
// Where none is, and nothing is stated of depths, their mean has a sigma of 1 1/m at first, which
// is not that of any scene: nothing of the translation would be learnt from the first frames
// (docs/filter.md).
//
// Of static landmarks only: the motion of a free one explains its parallax whatever rho is. The
// mean of the product, c, is left out.
#pragma once

#include "models/points/observation.h"

namespace slammot {

// The covariance of camera position r, anchor a and y of a landmark, in this order.
using PositionsCovariance = Eigen::Matrix<double, 9, 9>;

// Covariances of the errors of two landmarks: e of rho, d of anchor less camera.
struct ProductMoments {
  double e_e = 0.0;
  Eigen::Matrix3d d_d;
  Eigen::Vector3d d_e, e_d;  // of d_i and e_j, of e_i and d_j
};

// N_ij [px^2] of static landmarks i and j, with their J.
Eigen::Matrix2d second_order_noise(const Matrix23d& J_i, const Matrix23d& J_j,
                                   const ProductMoments& moments);

// N [px^2] of a static landmark at y that is expected at h.
Eigen::Matrix2d second_order_noise(const PointFunctions& point, const Eigen::Vector3d& y,
                                   const PositionsCovariance& P, const ObservedPixel& h);

}  // namespace slammot
