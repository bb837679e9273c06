// What the residuals of a graph's pixels cost.
#pragma once

#include <cmath>

#include "smoothers/graph/graph.h"

namespace slammot {

// The square of a pixel's residual with its loss, and the root of the loss's slope there.
inline double robust(const ceres::LossFunction* loss, double square, double* weight) {
  double rho[3] = {square, 1.0, 0.0};
  if (loss) loss->Evaluate(square, rho);
  if (weight) *weight = std::sqrt(rho[1]);
  return rho[0];
}

}  // namespace slammot
