#include "slammot/smoothers/far_map.h"

#include <Eigen/Cholesky>

#include "slammot/models/estimator.h"

namespace slammot {

namespace {

std::vector<int> rows_but(const FarMap& far, const std::set<VariableId>& ids) {
  std::vector<int> rows;
  for (const auto& [id, offset] : far.offsets) {
    if (ids.contains(id)) continue;
    for (int k = 0; k < FarMap::kDim; ++k) rows.push_back(offset + k);
  }
  return rows;
}

void keep(FarMap& far, const std::set<VariableId>& without, const std::vector<int>& rows) {
  far.mean = far.mean(rows).eval();
  far.K = far.K(rows, Eigen::all).eval();
  far.Sigma = far.Sigma(rows, rows).eval();
  for (const VariableId id : without) far.offsets.erase(id);
  int offset = 0;
  for (auto& [id, at] : far.offsets) {
    at = offset;
    offset += FarMap::kDim;
  }
}

}  // namespace

std::vector<int> FarMap::rows(const std::vector<VariableId>& ids) const {
  std::vector<int> rows;
  for (const VariableId id : ids) {
    for (int k = 0; k < kDim; ++k) rows.push_back(offsets.at(id) + k);
  }
  return rows;
}

void FarMap::forget(const std::set<VariableId>& ids) {
  if (!ids.empty()) keep(*this, ids, rows_but(*this, ids));
}

void FarMap::eliminate(const Eigen::MatrixXd& R, const Eigen::VectorXd& r) {
  const Eigen::Index n = R.rows();
  Eigen::MatrixXd E = K.leftCols(n);
  R.leftCols(n).triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(E);
  mean.noalias() -= E * r;
  Eigen::MatrixXd rest = K.rightCols(K.cols() - n);
  rest.noalias() -= E * R.rightCols(R.cols() - n);
  K = std::move(rest);
  Sigma.selfadjointView<Eigen::Lower>().rankUpdate(E);
  Sigma.triangularView<Eigen::StrictlyUpper>() = Sigma.transpose();
}

Returned take_back(FarMap& far, const std::vector<VariableId>& ids) {
  const std::set<VariableId> taken(ids.begin(), ids.end());
  const std::vector<int> p = far.rows(ids);
  const std::vector<int> i = rows_but(far, taken);
  Returned back{far.mean(p), far.K(p, Eigen::all), {}};
  const Eigen::LLT<Eigen::MatrixXd> of_covariance(far.Sigma(p, p));
  const auto n = static_cast<Eigen::Index>(p.size());
  const Eigen::LLT<Eigen::MatrixXd> of_information(
      of_covariance.solve(Eigen::MatrixXd::Identity(n, n)));
  if (of_covariance.info() != Eigen::Success || of_information.info() != Eigen::Success) {
    throw Diverged("the covariance of a landmark that returns is not positive definite");
  }
  back.U = of_information.matrixU();
  if (i.empty()) {  // BLAS refuses matrices without rows
    far = {};
    return back;
  }
  const Eigen::MatrixXd cross = far.Sigma(i, p);
  const Eigen::MatrixXd G = of_covariance.solve(cross.transpose()).transpose();
  keep(far, taken, i);
  Eigen::MatrixXd K(far.K.rows(), far.K.cols() + n);
  K.leftCols(n) = G;
  K.rightCols(far.K.cols()) = far.K - G * back.K;
  far.K = std::move(K);
  far.Sigma.noalias() -= G * cross.transpose();
  return back;
}

}  // namespace slammot
