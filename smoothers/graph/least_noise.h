// The noise of one step of a chain that leads from a prediction to a state.
#pragma once

#include <Eigen/QR>

#include "models/landmarks/landmark.h"

namespace slammot {

// The least n that brings G n nearest to `difference`. G is singular at infinity.
inline LandmarkVector least_noise(const LandmarkMatrix& G, const LandmarkVector& difference) {
  const Eigen::ColPivHouseholderQR<LandmarkMatrix> qr(G);
  if (qr.isInvertible()) return qr.solve(difference);
  return Eigen::CompleteOrthogonalDecomposition<LandmarkMatrix>(G).solve(difference);
}

}  // namespace slammot
