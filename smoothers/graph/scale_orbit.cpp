#include "smoothers/graph/scale_orbit.h"

#include <cmath>

#include "models/points/scale.h"

namespace slammot {

SmallVector ScaleOrbit::at(const SmallVector& x, double t) const {
  SmallVector y = x;
  switch (kind) {
    case Kind::kNone:
      break;
    case Kind::kPosition:
      y = centre + std::exp(t) * (x - centre);
      break;
    case Kind::kRates:
      y.head<3>() *= std::exp(t);
      break;
    case Kind::kLength:
      y *= std::exp(t);
      break;
    case Kind::kInverse:
      y *= std::exp(-t);
      break;
    case Kind::kPoint:
      y = scaled(*point, x, t);
      break;
  }
  return y;
}

BlockMatrix ScaleOrbit::jacobian(const SmallVector& x, double t) const {
  BlockMatrix J = BlockMatrix::Identity(x.size(), x.size());
  switch (kind) {
    case Kind::kNone:
      break;
    case Kind::kRates:
      J.diagonal().head<3>().setConstant(std::exp(t));
      break;
    case Kind::kPosition:
    case Kind::kLength:
      J *= std::exp(t);
      break;
    case Kind::kInverse:
      J *= std::exp(-t);
      break;
    case Kind::kPoint:
      J = scaled_jacobian(*point, x, t);
      break;
  }
  return J;
}

SmallVector ScaleOrbit::direction(const SmallVector& x) const {
  SmallVector n = SmallVector::Zero(x.size());
  switch (kind) {
    case Kind::kNone:
      break;
    case Kind::kPosition:
      n = x - centre;
      break;
    case Kind::kRates:
      n.head<3>() = x.head<3>();
      break;
    case Kind::kLength:
      n = x;
      break;
    case Kind::kInverse:
      n = -x;
      break;
    case Kind::kPoint:
      n = along_scale(*point, x);
      break;
  }
  return n;
}

}  // namespace slammot
