// Evidence of neighbouring tracks that move alike, as the points of one object do
// (`labels.pooled`).
//
// What such tracks say of one common motion w, each having started from the same prior N(0, P_0),
// is the product of what each has learnt:
//
//   P^-1 = P_0^-1 + sum of (P_i^-1 - P_0^-1),   P^-1 w = sum of P_i^-1 w_i.
//
// A classifier that is given (w, P) decides about the object. The errors that tracks share, those
// of the camera, count as often as there are tracks. Where w depends on the depth, such as v rho,
// neighbours are taken to be about equally far.
#pragma once

#include <span>
#include <vector>

#include "estimation/classification.h"
#include "models/measurement.h"

namespace slammot {

// Replaces w and P of each motion by those pooled with its neighbours: tracks measured within
// `radius` [px] that move alike, d'(P_i + P_j)^-1 d <= 2 n of the difference d of n numbers, twice
// its mean. `prior_sigmas` must be set, and each motion's track be in `z`, which is sorted by
// track. One whose covariance, own or pooled, is not positive definite stays as it is.
void pool_motions(std::span<const Observation> z, double radius,
                  std::vector<MotionBelief>& motions);

}  // namespace slammot
