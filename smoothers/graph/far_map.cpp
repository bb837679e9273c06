#include "smoothers/graph/far_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

#include "estimation/estimator.h"
#include "smoothers/solver/triangularise.h"

namespace slammot {

std::vector<int> FarMap::rows(const std::vector<VariableId>& ids) const {
  std::vector<int> rows;
  for (const VariableId id : ids) {
    for (int k = 0; k < kDim; ++k) rows.push_back(offsets.at(id) + k);
  }
  return rows;
}

Eigen::MatrixXd FarMap::covariance(const std::vector<int>& rows,
                                   const std::vector<int>& columns) const {
  const auto m = static_cast<Eigen::Index>(rows.size());
  const auto n = static_cast<Eigen::Index>(columns.size());
  return Eigen::MatrixXd::NullaryExpr(m, n, [&](Eigen::Index i, Eigen::Index j) {
    const int a = rows[static_cast<std::size_t>(i)], b = columns[static_cast<std::size_t>(j)];
    return Sigma(std::max(a, b), std::min(a, b));
  });
}

void FarMap::add(VariableId id, const Eigen::Vector3d& value, Eigen::Index column) {
  constexpr int kMore = 32;  // variables: the map is not copied for each that rests
  if (vacant.empty()) {
    const Eigen::Index old = rows(), more = kMore * kDim;
    mean.conservativeResizeLike(Eigen::VectorXd::Zero(old + more));
    K.conservativeResizeLike(Eigen::MatrixXd::Zero(old + more, K.cols()));
    Sigma.conservativeResizeLike(Eigen::MatrixXd::Zero(old + more, old + more));
    for (int k = kMore; k-- > 0;) vacant.push_back(static_cast<int>(old) + k * kDim);
  }
  const int row = offsets[id] = vacant.back();
  vacant.pop_back();
  mean.segment<kDim>(row) = value;
  K.block<kDim, kDim>(row, column).setIdentity();
}

void FarMap::forget(const std::vector<VariableId>& ids) {
  for (const VariableId id : ids) {
    const int row = offsets.at(id);
    mean.segment<kDim>(row).setZero();
    K.middleRows<kDim>(row).setZero();
    Sigma.middleRows<kDim>(row).setZero();
    Sigma.middleCols<kDim>(row).setZero();
    offsets.erase(id);
    vacant.push_back(row);
  }
}

void FarMap::eliminate(const std::vector<int>& stands, const Eigen::MatrixXd& T,
                       const Eigen::MatrixXd& R, const Eigen::VectorXd& r) {
  const Eigen::Index n = R.rows(), rest = R.cols() - n;
  const Eigen::MatrixXd K_s = K(Eigen::all, stands);
  Eigen::MatrixXd A = T.leftCols(n);
  R.leftCols(n).triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(A);
  mean.noalias() -= K_s * (A * r);
  K = K.rightCols(rest).eval();
  for (const int column : stands) {
    if (column >= n) K.col(column - n).setZero();
  }
  Eigen::MatrixXd T_rest = T.rightCols(rest);
  T_rest.noalias() -= A * R.rightCols(rest);
  K.noalias() += K_s * T_rest;
  // A A' = A_s' A_s, square where A is wide.
  const Eigen::MatrixXd A_s = A.cols() > A.rows() ? triangularise(A.transpose()) : A.transpose();
  Sigma.selfadjointView<Eigen::Lower>().rankUpdate(K_s * A_s.transpose());
}

// With Sigma_pp = L L' and X = Sigma_ip L^-T: the rest given x_p has K_i + X L^-1 (x_p - K_p b) and
// Sigma_ii - X X'.
Returned take_back(FarMap& far, const std::vector<VariableId>& ids) {
  const std::vector<int> p = far.rows(ids);
  const auto n = static_cast<Eigen::Index>(p.size());
  Returned back{far.mean(p), far.K(p, Eigen::all), {}};
  const Eigen::LLT<Eigen::MatrixXd> of_covariance(far.covariance(p, p));
  const Eigen::LLT<Eigen::MatrixXd> of_information(
      of_covariance.solve(Eigen::MatrixXd::Identity(n, n)));
  if (of_covariance.info() != Eigen::Success || of_information.info() != Eigen::Success) {
    throw Diverged("the covariance of a landmark that returns is not positive definite");
  }
  back.U = of_information.matrixU();
  std::vector<int> all(static_cast<std::size_t>(far.rows()));
  std::iota(all.begin(), all.end(), 0);
  Eigen::MatrixXd X = far.covariance(all, p);
  far.forget(ids);
  for (const int row : p) X.row(row).setZero();
  of_covariance.matrixU().solveInPlace<Eigen::OnTheRight>(X);
  far.Sigma.selfadjointView<Eigen::Lower>().rankUpdate(X, -1.0);
  of_covariance.matrixL().solveInPlace<Eigen::OnTheRight>(X);
  Eigen::MatrixXd K(far.rows(), n + far.K.cols());
  K.leftCols(n) = X;
  K.rightCols(far.K.cols()) = far.K - X * back.K;
  far.K = std::move(K);
  if (far.empty()) far = {};
  return back;
}

}  // namespace slammot
