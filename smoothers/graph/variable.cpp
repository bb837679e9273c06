#include "smoothers/graph/variable.h"

#include "models/so3.h"

namespace slammot {

SmallVector plus(const ceres::Manifold* manifold, const SmallVector& x, const SmallVector& d) {
  if (!manifold) return x + d;
  SmallVector y(x.size());
  manifold->Plus(x.data(), d.data(), y.data());
  return y;
}

SmallVector minus(const ceres::Manifold* manifold, const SmallVector& y, const SmallVector& x) {
  if (!manifold) return y - x;
  SmallVector d(manifold->TangentSize());
  manifold->Minus(y.data(), x.data(), d.data());
  return d;
}

SmallMatrix transport(const Variable& x, const SmallVector& x0) {
  SmallMatrix T = SmallMatrix::Identity(x.dim(), x.dim());
  if (!x.manifold) return T;
  const SmallVector d = minus(x.manifold, x.value, x0);
  T.topLeftCorner<3, 3>() = inverse_right_jacobian_so3(d.head<3>());
  return T;
}

}  // namespace slammot
