#include "smoothers/graph/conditional_map.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "estimation/estimator.h"
#include "smoothers/linear/triangularise.h"

namespace slammot {

namespace {

// Many rows at once, so that a level is not copied for every variable.
constexpr int kMoreRows = 96;
}  // namespace

int ConditionalMap::Level::add(int rows) {
  if (rows == kDim && !vacant.empty()) {
    const int row = vacant.back();
    vacant.pop_back();
    return row;
  }
  const Eigen::Index old = mean.size(), more = std::max(rows, kMoreRows) / kDim * kDim + kDim;
  mean.conservativeResizeLike(Eigen::VectorXd::Zero(old + more));
  K.conservativeResizeLike(Eigen::MatrixXd::Zero(old + more, K.cols()));
  Sigma.conservativeResizeLike(Eigen::MatrixXd::Zero(old + more, old + more));
  const Eigen::Index used = (rows + kDim - 1) / kDim * kDim;
  for (Eigen::Index row = old + more - kDim; row >= old + used; row -= kDim) {
    vacant.push_back(static_cast<int>(row));
  }
  return static_cast<int>(old);
}

void ConditionalMap::Level::clear(int row) {
  mean.segment<kDim>(row).setZero();
  K.middleRows<kDim>(row).setZero();
  Sigma.middleRows<kDim>(row).setZero();
  Sigma.middleCols<kDim>(row).setZero();
}

Eigen::MatrixXd ConditionalMap::Level::covariance(const std::vector<int>& rows,
                                                  const std::vector<int>& columns) const {
  const auto m = static_cast<Eigen::Index>(rows.size());
  const auto n = static_cast<Eigen::Index>(columns.size());
  return Eigen::MatrixXd::NullaryExpr(m, n, [&](Eigen::Index i, Eigen::Index j) {
    const int a = rows[static_cast<std::size_t>(i)], b = columns[static_cast<std::size_t>(j)];
    return Sigma(std::max(a, b), std::min(a, b));
  });
}

std::vector<int> ConditionalMap::rows(const std::vector<VariableId>& ids, bool is_far) const {
  std::vector<int> rows;
  for (const VariableId id : ids) {
    const Place& place = places_.at(id);
    if (place.is_far != is_far) continue;
    for (int k = 0; k < kDim; ++k) rows.push_back(place.row + k);
  }
  return rows;
}

Eigen::Vector3d ConditionalMap::z_of(const Place& place, const Eigen::VectorXd& d) const {
  if (!place.is_far) {
    return near_.mean.segment<kDim>(place.row) + near_.K.middleRows<kDim>(place.row) * d;
  }
  const Eigen::VectorXd stem = near_.mean(stem_) + near_.K(stem_, Eigen::all) * d;
  return far_.mean.segment<kDim>(place.row) +
         far_.K.middleRows<kDim>(place.row).leftCols(stem.size()) * stem;
}

Eigen::Vector3d ConditionalMap::grow(const Place& place, const Eigen::Vector3d& z,
                                     double lambda) const {
  const double gamma = scale_ - place.scale + lambda;
  if (place.orbit.kind == ScaleOrbit::Kind::kNone || gamma == 0.0) return z;
  return place.orbit.at(z - gamma * place.n0, gamma);
}

ConditionalMap::Grown ConditionalMap::grown(const Place& place, const Eigen::Vector3d& z,
                                            double lambda) const {
  const double gamma = scale_ - place.scale + lambda;
  Grown at;
  at.x = grow(place, z, lambda);
  at.M = place.orbit.jacobian(z - gamma * place.n0, gamma);
  at.of_scale = place.orbit.direction(at.x) - at.M * place.n0;
  return at;
}

SmallVector ConditionalMap::value(VariableId id, const ScaleChart& b) const {
  const Place& place = places_.at(id);
  return grow(place, z_of(place, b.difference()), b.lambda());
}

void ConditionalMap::values(const ScaleChart& b, Values& result) const {
  result.map_ = this;
  result.lambda_ = b.lambda();
  if (empty()) return;
  result.near_ = near_.mean;
  result.near_.noalias() += near_.K * b.difference();
  if (stem_.empty()) return;
  const Eigen::VectorXd stem = result.near_(stem_);
  result.far_ = far_.mean;
  result.far_.noalias() += far_.K.leftCols(stem.size()) * stem;
}

Eigen::Vector3d ConditionalMap::Values::operator[](VariableId id) const {
  const Place& place = map_->places_.at(id);
  return map_->grow(place, (place.is_far ? far_ : near_).segment<kDim>(place.row), lambda_);
}

Eigen::MatrixXd ConditionalMap::gain(const std::vector<VariableId>& ids,
                                     const ScaleChart& b) const {
  Eigen::MatrixXd K(kDim * std::ssize(ids), near_.K.cols());
  Eigen::Index row = 0;
  for (const VariableId id : ids) {
    const Place& place = places_.at(id);
    auto own = K.middleRows<kDim>(row);
    if (place.is_far) {
      own = far_.K.middleRows<kDim>(place.row).leftCols(std::ssize(stem_)) *
            near_.K(stem_, Eigen::all);
    } else {
      own = near_.K.middleRows<kDim>(place.row);
    }
    row += kDim;
  }
  b.apply(K);
  if (!b.keeps_scale()) return K;
  row = 0;
  for (const VariableId id : ids) {
    const Place& place = places_.at(id);
    const Grown at = grown(place, z_of(place, b.difference()), b.lambda());
    auto own = K.middleRows<kDim>(row);
    own = (at.M * own).eval();
    own.noalias() += at.of_scale * b.gradient().transpose();
    row += kDim;
  }
  return K;
}

// P := M P M', P being of z.
void ConditionalMap::turn(const std::vector<VariableId>& ids, Eigen::MatrixXd& P) const {
  Eigen::Index row = 0;
  for (const VariableId id : ids) {
    const Place& place = places_.at(id);
    const Eigen::VectorXd d = Eigen::VectorXd::Zero(near_.K.cols());
    const Eigen::Matrix3d M = grown(place, z_of(place, d), 0.0).M;
    P.middleRows<kDim>(row) = (M * P.middleRows<kDim>(row)).eval();
    P.middleCols<kDim>(row) = (P.middleCols<kDim>(row) * M.transpose()).eval();
    row += kDim;
  }
}

// With A = dz/d(near): A Sigma_near A', and of far variables their own.
Eigen::MatrixXd ConditionalMap::covariance(const std::vector<VariableId>& ids) const {
  const Eigen::Index n = kDim * std::ssize(ids);
  std::vector<int> used = stem_;
  std::vector<int> far_rows, far_at;
  for (const VariableId id : ids) {
    const Place& place = places_.at(id);
    for (int k = 0; k < kDim && !place.is_far; ++k) used.push_back(place.row + k);
  }
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, std::ssize(used));
  Eigen::Index row = 0, near_column = std::ssize(stem_);
  for (const VariableId id : ids) {
    const Place& place = places_.at(id);
    if (place.is_far) {
      A.middleRows<kDim>(row).leftCols(std::ssize(stem_)) =
          far_.K.middleRows<kDim>(place.row).leftCols(std::ssize(stem_));
      for (int k = 0; k < kDim; ++k) {
        far_rows.push_back(place.row + k);
        far_at.push_back(static_cast<int>(row) + k);
      }
    } else {
      A.block<kDim, kDim>(row, near_column).setIdentity();
      near_column += kDim;
    }
    row += kDim;
  }
  Eigen::MatrixXd P = A * near_.covariance(used, used) * A.transpose();
  if (!far_rows.empty()) {
    const Eigen::MatrixXd late = pending_(far_rows, Eigen::seqN(0, pending_cols_));
    const Eigen::MatrixXd own = far_.covariance(far_rows, far_rows) - late * late.transpose();
    P(far_at, far_at) += own;
  }
  if (keeps_scale_) turn(ids, P);
  return P;
}

void ConditionalMap::deactivate(const Variable& variable, Eigen::Index column) {
  const int row = near_.add(kDim);
  places_[variable.id] = {false, row, variable.orbit, variable.orbit.direction(variable.value),
                          scale_};
  near_.mean.segment<kDim>(row) = variable.value;
  near_.K.block<kDim, kDim>(row, column).setIdentity();
}

void ConditionalMap::forget(const std::vector<VariableId>& ids) {
  for (const VariableId id : ids) {
    const Place place = places_.at(id);
    places_.erase(id);
    Level& level = place.is_far ? far_ : near_;
    // What is far depends on the stem still.
    if (!place.is_far && std::ranges::find(stem_, place.row) != stem_.end()) continue;
    level.clear(place.row);
    if (place.is_far) pending_.middleRows<kDim>(place.row).setZero();
    level.vacant.push_back(place.row);
  }
  if (places_.empty()) *this = ConditionalMap(keeps_scale_);
}

void ConditionalMap::eliminate(const std::vector<int>& columns, const Eigen::MatrixXd& T,
                               const Eigen::MatrixXd& R, const Eigen::VectorXd& r) {
  const Eigen::Index n = R.rows(), rest = R.cols() - n;
  Eigen::MatrixXd& K = near_.K;
  if (columns.empty()) {  // the map does not depend on what goes; Eigen wants no empty products
    K = K.rightCols(rest).eval();
    return;
  }
  const Eigen::MatrixXd K_s = K(Eigen::all, columns);
  Eigen::MatrixXd A = T.leftCols(n);
  R.leftCols(n).triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(A);
  near_.mean.noalias() -= K_s * (A * r);
  K = K.rightCols(rest).eval();
  for (const int column : columns) {
    if (column >= n) K.col(column - n).setZero();
  }
  Eigen::MatrixXd T_rest = T.rightCols(rest);
  T_rest.noalias() -= A * R.rightCols(rest);
  K.noalias() += K_s * T_rest;
  // A A' = A_s' A_s, square where A is wide.
  const Eigen::MatrixXd A_s =
      A.cols() > A.rows() ? triangular_factor(A.transpose()) : A.transpose();
  near_.Sigma.selfadjointView<Eigen::Lower>().rankUpdate(K_s * A_s.transpose());
  const Eigen::Index landmarks = near_.mean.size() - std::ssize(near_.vacant) * kDim;
  if (landmarks - std::ssize(stem_) > std::max<Eigen::Index>(rest, kMoreRows)) fold();
}

// The same within near. With d(x) = M e + K d(b) of those that return, e is M^-1 (d(x) - K d(b)),
// and the others have the gain X on it.
ConditionalMap::Reactivated ConditionalMap::reactivate(const std::vector<VariableId>& ids,
                                                       const ScaleChart& b0) {
  lift(ids);
  const std::vector<int> p = rows(ids, false);
  const auto n = static_cast<Eigen::Index>(p.size());
  Reactivated back{near_.mean(p), near_.K(p, Eigen::all), {}};
  Eigen::MatrixXd P = near_.covariance(p, p), M = Eigen::MatrixXd::Identity(n, n);
  Eigen::MatrixXd z_mean = back.mean, z_K = back.K;
  for (std::size_t i = 0; i < ids.size() && b0.keeps_scale(); ++i) {
    const auto row = static_cast<Eigen::Index>(i) * kDim;
    const Grown at = grown(places_.at(ids[i]), back.mean.segment<kDim>(row), 0.0);
    back.mean.segment<kDim>(row) = at.x;
    M.block<kDim, kDim>(row, row) = at.M;
    back.K.middleRows<kDim>(row) = at.M * z_K.middleRows<kDim>(row);
    back.K.middleRows<kDim>(row).noalias() += at.of_scale * b0.gradient().transpose();
  }
  const Eigen::LLT<Eigen::MatrixXd> of_covariance(P);
  const Eigen::LLT<Eigen::MatrixXd> of_information(M * P * M.transpose());
  if (of_covariance.info() != Eigen::Success || of_information.info() != Eigen::Success) {
    throw Diverged("the covariance of a landmark that returns is not positive definite");
  }
  const Eigen::LLT<Eigen::MatrixXd> upper(of_information.solve(Eigen::MatrixXd::Identity(n, n)));
  if (upper.info() != Eigen::Success) {
    throw Diverged("the covariance of a landmark that returns is not positive definite");
  }
  back.U = upper.matrixU();
  Eigen::MatrixXd X = near_.covariance(indices(near_.mean.size()), p);
  forget_rows(ids);
  for (const int row : p) X.row(row).setZero();
  of_covariance.matrixU().solveInPlace<Eigen::OnTheRight>(X);
  near_.Sigma.selfadjointView<Eigen::Lower>().rankUpdate(X, -1.0);
  of_covariance.matrixL().solveInPlace<Eigen::OnTheRight>(X);
  const Eigen::MatrixXd M_inverse = M.inverse();
  X = (X * M_inverse).eval();
  Eigen::MatrixXd K(near_.mean.size(), n + near_.K.cols());
  K.leftCols(n) = X;
  K.rightCols(near_.K.cols()) = near_.K - X * back.K;
  // What is far goes on to depend on these: now on the active ones.
  const Eigen::MatrixXd rest = z_K - M_inverse * back.K;
  for (Eigen::Index i = 0; i < n; ++i) {
    const int row = p[static_cast<std::size_t>(i)];
    if (std::ranges::find(stem_, row) == stem_.end()) continue;
    near_.mean(row) = z_mean(i);
    K.row(row).head(n) = M_inverse.row(i);
    K.row(row).tail(rest.cols()) = rest.row(i);
  }
  near_.K = std::move(K);
  if (empty()) *this = ConditionalMap(keeps_scale_);
  return back;
}

// Their rows are exactly zero from now on.
void ConditionalMap::forget_rows(const std::vector<VariableId>& ids) {
  for (const VariableId id : ids) {
    const int row = places_.at(id).row;
    places_.erase(id);
    near_.clear(row);
    if (std::ranges::find(stem_, row) == stem_.end()) near_.vacant.push_back(row);
  }
}

void ConditionalMap::relinearise(const ScaleChart& b) {
  if (empty()) return;
  near_.mean += near_.K * b.difference();
  b.apply(near_.K);
  scale_ += b.lambda();
}

void ConditionalMap::relinearise(const MarginalPrior& prior, int total) {
  if (!empty()) relinearise(prior.chart());
  const Eigen::MatrixXd K = std::move(near_.K);
  near_.K.setZero(near_.mean.size(), total);
  if (empty()) return;
  for (const MarginalPrior::Block& block : prior.blocks()) {
    if (block.variable->column < 0) continue;  // of a considered landmark: K is zero there
    near_.K.middleCols(block.variable->column, block.dim()) =
        K.middleCols(block.offset, block.dim());
  }
}

void ConditionalMap::add_independent(Eigen::Index columns) {
  if (empty() || columns == 0) return;
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(near_.K.rows(), near_.K.cols() + columns);
  K.rightCols(near_.K.cols()) = near_.K;
  near_.K = std::move(K);
}

void ConditionalMap::condition_on_zero(const MarginalPrior::Block& block) {
  if (empty()) return;
  const int dim = block.dim();
  const Eigen::Index kept = near_.K.cols() - dim;
  near_.mean.noalias() -= near_.K.middleCols(block.offset, dim) * block.x0;
  Eigen::MatrixXd K(near_.mean.size(), kept);
  K << near_.K.leftCols(block.offset), near_.K.rightCols(kept - block.offset);
  near_.K = std::move(K);
}

}  // namespace slammot
