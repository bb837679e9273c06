#include "smoothers/solver/given_others.h"

#include <Eigen/LU>

#include "smoothers/linear/lapack.h"

namespace slammot {

void LandmarkBlock::weigh_pixel(int pixel, Eigen::Ref<Eigen::MatrixXd> B,
                                Eigen::Matrix2d& own) const {
  const int row = 2 * pixel;
  Eigen::Matrix<double, 2, Eigen::Dynamic> weight =
      Eigen::Matrix<double, 2, Eigen::Dynamic>::Zero(2, rows_);
  if (independent_) {
    weight.middleCols<2>(row).setIdentity();
  } else {
    weight = (*P_).middleRows<2>(row);
  }
  own = weight.middleCols<2>(row);
  B.setZero();
  for (int i = 0; i < pixels_; ++i) {
    B.middleRows<6>(poses_[static_cast<std::size_t>(i)]) +=
        (*A_).middleRows<2>(2 * i).transpose() * weight.middleCols<2>(2 * i).transpose();
  }
  for (const Shared& s : shared_) {
    B.middleRows(s.core, s.dim).noalias() +=
        (*S_).middleCols(s.column, s.dim).transpose() * weight.transpose();
  }
}

void LandmarkBlock::weigh(const Eigen::Ref<const Eigen::MatrixXd>& A, Eigen::Ref<Eigen::MatrixXd> C,
                          MotionMatrix& own) const {
  const Eigen::Index pixels = A.rows();
  Eigen::MatrixXd PA = Eigen::MatrixXd::Zero(rows_, A.cols());  // birth's rows stand last
  if (independent_) {
    PA.topRows(pixels) = A;
  } else {
    PA.noalias() = (*P_).leftCols(pixels) * A;
  }
  own = A.transpose() * PA.topRows(pixels);
  C.setZero();
  for (int i = 0; i < pixels_; ++i) {
    C.middleRows<6>(poses_[static_cast<std::size_t>(i)]).noalias() +=
        (*A_).middleRows<2>(2 * i).transpose() * PA.middleRows<2>(2 * i);
  }
  for (const Shared& s : shared_) {
    C.middleRows(s.core, s.dim).noalias() += (*S_).middleCols(s.column, s.dim).transpose() * PA;
  }
}

void NormalEquations::whiten(Eigen::Ref<Eigen::MatrixXd> C) const { solve_lower_in_place(*S_, C); }

void GivenOthers::add(const NormalEquations& equations, const LandmarkBlock& block, int pixel,
                      const Eigen::Vector2d& e, bool is_held) {
  Tested& tested = tested_.emplace_back();
  tested.e = e;
  tested.is_held = is_held;
  const auto rows = equations.core_dim();
  columns_.resize(columns_.size() + static_cast<std::size_t>(2 * rows));
  Eigen::Map<Eigen::MatrixXd> all(columns_.data(), rows, 2 * std::ssize(tested_));
  block.weigh_pixel(pixel, all.rightCols<2>(), tested.P);
}

std::vector<double> GivenOthers::nis(const NormalEquations& equations) {
  Eigen::Map<Eigen::MatrixXd> C(columns_.data(), equations.core_dim(), 2 * std::ssize(tested_));
  if (!tested_.empty()) equations.whiten(C);
  std::vector<double> result;
  for (const Tested& tested : tested_) {
    const auto own = C.middleCols<2>(2 * std::ssize(result));
    const Eigen::Matrix2d of_core = own.transpose() * own;
    const Eigen::Matrix2d covariance =
        tested.is_held ? tested.P - of_core : Eigen::Matrix2d(tested.P + of_core);
    result.push_back(tested.e.dot(covariance.inverse() * tested.e));
  }
  tested_.clear();
  columns_.clear();
  return result;
}

}  // namespace slammot
