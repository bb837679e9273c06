#include "smoothers/graph/conditional_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

#include "estimation/estimator.h"
#include "smoothers/linear/triangularise.h"

namespace slammot {

std::vector<int> ConditionalMap::rows(const std::vector<VariableId>& ids) const {
  std::vector<int> rows;
  for (const VariableId id : ids) {
    for (int k = 0; k < kDim; ++k) rows.push_back(entries_.at(id).row + k);
  }
  return rows;
}

SmallVector ConditionalMap::value(VariableId id, const Eigen::VectorXd& d) const {
  const int row = entries_.at(id).row;
  return mean_.segment<kDim>(row) + K_.middleRows<kDim>(row) * d;
}

std::map<VariableId, SmallVector> ConditionalMap::values(const Eigen::VectorXd& d) const {
  std::map<VariableId, SmallVector> values;
  if (empty()) return values;
  const Eigen::VectorXd x = mean_ + K_ * d;
  for (const auto& [id, entry] : entries_) values[id] = x.segment<kDim>(entry.row);
  return values;
}

Eigen::MatrixXd ConditionalMap::gain(const std::vector<VariableId>& ids) const {
  return K_(rows(ids), Eigen::all);
}

Eigen::MatrixXd ConditionalMap::covariance(const std::vector<VariableId>& ids) const {
  const std::vector<int> at = rows(ids);
  return covariance(at, at);
}

Eigen::MatrixXd ConditionalMap::covariance(const std::vector<int>& rows,
                                           const std::vector<int>& columns) const {
  const auto m = static_cast<Eigen::Index>(rows.size());
  const auto n = static_cast<Eigen::Index>(columns.size());
  return Eigen::MatrixXd::NullaryExpr(m, n, [&](Eigen::Index i, Eigen::Index j) {
    const int a = rows[static_cast<std::size_t>(i)], b = columns[static_cast<std::size_t>(j)];
    return Sigma_(std::max(a, b), std::min(a, b));
  });
}

// Many rows at once, so that the map is not copied for every variable.
void ConditionalMap::make_room() {
  constexpr int kMore = 32;  // variables
  const Eigen::Index old = mean_.size(), more = kMore * kDim;
  mean_.conservativeResizeLike(Eigen::VectorXd::Zero(old + more));
  K_.conservativeResizeLike(Eigen::MatrixXd::Zero(old + more, K_.cols()));
  Sigma_.conservativeResizeLike(Eigen::MatrixXd::Zero(old + more, old + more));
  for (int k = kMore; k-- > 0;) vacant_.push_back(static_cast<int>(old) + k * kDim);
}

void ConditionalMap::deactivate(const Variable& variable, Eigen::Index column) {
  if (vacant_.empty()) make_room();
  const int row = vacant_.back();
  vacant_.pop_back();
  entries_[variable.id] = {row, variable};
  mean_.segment<kDim>(row) = variable.value;
  K_.block<kDim, kDim>(row, column).setIdentity();
}

void ConditionalMap::forget(const std::vector<VariableId>& ids) {
  for (const VariableId id : ids) {
    const int row = entries_.at(id).row;
    mean_.segment<kDim>(row).setZero();
    K_.middleRows<kDim>(row).setZero();
    Sigma_.middleRows<kDim>(row).setZero();
    Sigma_.middleCols<kDim>(row).setZero();
    entries_.erase(id);
    vacant_.push_back(row);
  }
}

void ConditionalMap::eliminate(const std::vector<int>& columns, const Eigen::MatrixXd& T,
                               const Eigen::MatrixXd& R, const Eigen::VectorXd& r) {
  const Eigen::Index n = R.rows(), rest = R.cols() - n;
  if (columns.empty()) {  // the map does not depend on what goes; Eigen wants no empty products
    K_ = K_.rightCols(rest).eval();
    return;
  }
  const Eigen::MatrixXd K_s = K_(Eigen::all, columns);
  Eigen::MatrixXd A = T.leftCols(n);
  R.leftCols(n).triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(A);
  mean_.noalias() -= K_s * (A * r);
  K_ = K_.rightCols(rest).eval();
  for (const int column : columns) {
    if (column >= n) K_.col(column - n).setZero();
  }
  Eigen::MatrixXd T_rest = T.rightCols(rest);
  T_rest.noalias() -= A * R.rightCols(rest);
  K_.noalias() += K_s * T_rest;
  // A A' = A_s' A_s, square where A is wide.
  const Eigen::MatrixXd A_s = A.cols() > A.rows() ? triangularise(A.transpose()) : A.transpose();
  Sigma_.selfadjointView<Eigen::Lower>().rankUpdate(K_s * A_s.transpose());
}

// With p the rows of `ids`, Sigma_pp = L L' and X = Sigma_ip L^-T, the others given x_p have the
// gain K_i + X L^-1 (x_p - K_p b) and the covariance Sigma_ii - X X'.
ConditionalMap::Reactivated ConditionalMap::reactivate(const std::vector<VariableId>& ids,
                                                       const Eigen::VectorXd& d) {
  const std::vector<int> p = rows(ids);
  const auto n = static_cast<Eigen::Index>(p.size());
  Reactivated back{{}, mean_(p), K_(p, Eigen::all), {}};
  const Eigen::LLT<Eigen::MatrixXd> of_covariance(covariance(p, p));
  const Eigen::LLT<Eigen::MatrixXd> of_information(
      of_covariance.solve(Eigen::MatrixXd::Identity(n, n)));
  if (of_covariance.info() != Eigen::Success || of_information.info() != Eigen::Success) {
    throw Diverged("the covariance of a landmark that returns is not positive definite");
  }
  back.U = of_information.matrixU();
  for (const VariableId id : ids) {
    back.variables.push_back(entries_.at(id).variable);
    back.variables.back().value = value(id, d);
  }
  std::vector<int> all(static_cast<std::size_t>(mean_.size()));
  std::iota(all.begin(), all.end(), 0);
  Eigen::MatrixXd X = covariance(all, p);
  forget(ids);
  for (const int row : p) X.row(row).setZero();
  of_covariance.matrixU().solveInPlace<Eigen::OnTheRight>(X);
  Sigma_.selfadjointView<Eigen::Lower>().rankUpdate(X, -1.0);
  of_covariance.matrixL().solveInPlace<Eigen::OnTheRight>(X);
  Eigen::MatrixXd K(mean_.size(), n + K_.cols());
  K.leftCols(n) = X;
  K.rightCols(K_.cols()) = K_ - X * back.K;
  K_ = std::move(K);
  if (empty()) *this = {};
  return back;
}

void ConditionalMap::relinearise(const MarginalPrior& prior) {
  if (empty()) return;
  mean_ += K_ * prior.difference();
  prior.transport(K_);
}

void ConditionalMap::relinearise(const MarginalPrior& prior,
                                 const std::map<VariableId, int>& columns, int total) {
  Eigen::MatrixXd K = std::move(K_);
  K_.setZero(mean_.size(), total);
  if (empty()) return;
  mean_.noalias() += K * prior.difference();
  prior.transport(K);
  for (const MarginalPrior::Block& block : prior.blocks()) {
    K_.middleCols(columns.at(block.variable->id), block.dim()) =
        K.middleCols(block.offset, block.dim());
  }
}

void ConditionalMap::condition_on_zero(const MarginalPrior::Block& block) {
  if (empty()) return;
  const int dim = block.dim();
  const Eigen::Index kept = K_.cols() - dim;
  mean_.noalias() -= K_.middleCols(block.offset, dim) * block.x0;
  Eigen::MatrixXd K(mean_.size(), kept);
  K << K_.leftCols(block.offset), K_.rightCols(kept - block.offset);
  K_ = std::move(K);
}

}  // namespace slammot
