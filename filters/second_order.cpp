#include "filters/second_order.h"

namespace slammot {

Eigen::Matrix2d second_order_noise(const Matrix23d& J_i, const Matrix23d& J_j,
                                   const ProductMoments& m) {
  return J_i * (m.e_e * m.d_d + m.d_e * m.e_d.transpose()) * J_j.transpose();
}

Eigen::Matrix2d second_order_noise(const PointFunctions& point, const Eigen::Vector3d& y,
                                   const PositionsCovariance& P, const ObservedPixel& h) {
  const auto block = [&](int i, int j) { return P.block<3, 3>(3 * i, 3 * j); };
  const Eigen::RowVector3d J_rho = point.inverse_depth_jacobian(y);
  ProductMoments moments;
  moments.e_e = (J_rho * block(2, 2)).dot(J_rho);
  moments.d_d = block(1, 1) - block(1, 0) - block(0, 1) + block(0, 0);
  moments.d_e = moments.e_d = (block(1, 2) - block(0, 2)) * J_rho.transpose();
  return second_order_noise(h.J_world, h.J_world, moments);
}

}  // namespace slammot
