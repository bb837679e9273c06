#include "filters/second_order.h"

namespace slammot {

Eigen::Matrix2d second_order_noise(const PointFunctions& point, const Eigen::Vector3d& y,
                                   const PositionsCovariance& P, const ObservedPixel& h) {
  const auto block = [&](int i, int j) { return P.block<3, 3>(3 * i, 3 * j); };
  const Eigen::Matrix3d P_d = block(1, 1) - block(1, 0) - block(0, 1) + block(0, 0);
  const Eigen::RowVector3d J_rho = point.inverse_depth_jacobian(y);
  const double P_rho = (J_rho * block(2, 2)).dot(J_rho);
  const Eigen::RowVector3d c = J_rho * (block(2, 1) - block(2, 0));
  return h.J_world * (P_rho * P_d + c.transpose() * c) * h.J_world.transpose();
}

}  // namespace slammot
