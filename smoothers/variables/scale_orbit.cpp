#include "smoothers/variables/scale_orbit.h"

#include <cmath>

#include "models/points/scale.h"

namespace slammot {

namespace {

constexpr int kVelocityOfRates = 3;

}  // namespace

int ScaleOrbit::exponent() const {
  if (kind == Kind::kNone) return 0;
  return kind == Kind::kInverse ? -1 : 1;
}

SmallVector ScaleOrbit::from_centre(const SmallVector& x) const {
  SmallVector d = x;
  if (kind == Kind::kPosition) d -= centre;
  if (kind == Kind::kRates) d.tail(d.size() - kVelocityOfRates).setZero();
  return d;
}

// x + (e^(s t) - 1) (x - centre), s being the exponent.
SmallVector ScaleOrbit::at(const SmallVector& x, double t) const {
  if (kind == Kind::kPoint) return scaled(*point, x, t);
  return x + std::expm1(exponent() * t) * from_centre(x);
}

BlockMatrix ScaleOrbit::jacobian(const SmallVector& x, double t) const {
  if (kind == Kind::kPoint) return scaled_jacobian(*point, x, t);
  BlockMatrix J = BlockMatrix::Identity(x.size(), x.size());
  const Eigen::Index n = kind == Kind::kRates ? kVelocityOfRates : x.size();
  J.diagonal().head(n).setConstant(std::exp(exponent() * t));
  return J;
}

SmallVector ScaleOrbit::direction(const SmallVector& x) const {
  if (kind == Kind::kPoint) return along_scale(*point, x);
  return exponent() * from_centre(x);
}

}  // namespace slammot
