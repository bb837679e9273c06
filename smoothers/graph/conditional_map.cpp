#include "smoothers/graph/conditional_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

#include "estimation/estimator.h"
#include "smoothers/linear/triangularise.h"

namespace slammot {

namespace {

// Many rows at once, so that a level is not copied for every variable.
constexpr int kMoreRows = 96;
// Columns by which Sigma is late before it is brought up to date.
constexpr int kPendingColumns = 96;

std::vector<int> all(Eigen::Index count) {
  std::vector<int> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

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

SmallVector ConditionalMap::value(VariableId id, const Eigen::VectorXd& d) const {
  const Place& place = places_.at(id);
  if (!place.is_far) {
    return near_.mean.segment<kDim>(place.row) + near_.K.middleRows<kDim>(place.row) * d;
  }
  const Eigen::VectorXd stem = near_.mean(stem_) + near_.K(stem_, Eigen::all) * d;
  return far_.mean.segment<kDim>(place.row) +
         far_.K.middleRows<kDim>(place.row).leftCols(stem.size()) * stem;
}

void ConditionalMap::values(const Eigen::VectorXd& d, Values& result) const {
  result.map_ = this;
  if (empty()) return;
  result.near_ = near_.mean;
  result.near_.noalias() += near_.K * d;
  if (stem_.empty()) return;
  const Eigen::VectorXd stem = result.near_(stem_);
  result.far_ = far_.mean;
  result.far_.noalias() += far_.K.leftCols(stem.size()) * stem;
}

Eigen::Vector3d ConditionalMap::Values::operator[](VariableId id) const {
  const Place& place = map_->places_.at(id);
  return (place.is_far ? far_ : near_).segment<kDim>(place.row);
}

Eigen::MatrixXd ConditionalMap::gain(const std::vector<VariableId>& ids) const {
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
  return K;
}

// With A = d(x)/d(near): A Sigma_near A', and of far variables their own.
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
  if (far_rows.empty()) return P;
  const Eigen::MatrixXd late = pending_(far_rows, Eigen::seqN(0, pending_cols_));
  const Eigen::MatrixXd own = far_.covariance(far_rows, far_rows) - late * late.transpose();
  P(far_at, far_at) += own;
  return P;
}

void ConditionalMap::deactivate(const Variable& variable, Eigen::Index column) {
  const int row = near_.add(kDim);
  places_[variable.id] = {false, row};
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
  if (places_.empty()) *this = {};
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

// far := (far, near) given the prior's variables, which become the stem.
void ConditionalMap::fold() {
  subtract_pending();
  const Eigen::Index stem = std::ssize(stem_), n = near_.K.cols();
  Eigen::MatrixXd K_far = Eigen::MatrixXd::Zero(far_.mean.size(), n), of_stem;
  if (stem > 0) {
    of_stem = far_.K.leftCols(stem);
    K_far.noalias() += of_stem * near_.K(stem_, Eigen::all);
    far_.mean.noalias() += of_stem * near_.mean(stem_);
    const Eigen::MatrixXd V = of_stem * near_.covariance(stem_, stem_);
    // V of_stem' is symmetric; the lower triangle, by panels.
    constexpr Eigen::Index kPanel = 128;
    for (Eigen::Index c = 0; c < V.rows(); c += kPanel) {
      const Eigen::Index width = std::min(kPanel, V.rows() - c);
      far_.Sigma.block(c, c, V.rows() - c, width).noalias() +=
          V.bottomRows(V.rows() - c) * of_stem.middleRows(c, width).transpose();
    }
  }
  far_.K = std::move(K_far);
  std::vector<int> near_rows, far_rows;
  for (auto& [id, place] : places_) {
    if (place.is_far) continue;
    const int row = far_.add(kDim);
    for (int k = 0; k < kDim; ++k) {
      near_rows.push_back(place.row + k);
      far_rows.push_back(row + k);
    }
    place = {true, row};
  }
  of_stem.conservativeResizeLike(Eigen::MatrixXd::Zero(far_.mean.size(), stem));
  far_.mean(far_rows) = near_.mean(near_rows);
  far_.K(far_rows, Eigen::all) = near_.K(near_rows, Eigen::all);
  Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(std::ssize(near_rows), far_.mean.size());
  if (stem > 0) cross.noalias() += near_.covariance(near_rows, stem_) * of_stem.transpose();
  cross(Eigen::all, far_rows) = near_.covariance(near_rows, near_rows);
  for (std::size_t i = 0; i < far_rows.size(); ++i) {
    const int row = far_rows[i];
    far_.Sigma.row(row).head(row + 1) = cross.row(static_cast<int>(i)).head(row + 1);
    far_.Sigma.col(row).tail(far_.mean.size() - row) =
        cross.row(static_cast<int>(i)).tail(far_.mean.size() - row).transpose();
  }
  start_stem();
}

// near is the prior's variables, exactly.
void ConditionalMap::start_stem() {
  const Eigen::Index n = near_.K.cols();
  near_ = {};
  near_.K.resize(0, n);
  near_.add(static_cast<int>(n));
  near_.K.topLeftCorner(n, n).setIdentity();
  stem_ = all(n);
  pending_.setZero(far_.mean.size(), kPendingColumns);
  pending_cols_ = 0;
}

void ConditionalMap::subtract_pending() {
  if (pending_cols_ == 0) return;
  far_.Sigma.selfadjointView<Eigen::Lower>().rankUpdate(pending_.leftCols(pending_cols_), -1.0);
  pending_cols_ = 0;
}

// Far variables become a part of the stem, on which the others are conditional. With q their rows,
// Sigma_qq = L L' and X = Sigma_iq L^-T, the others have the gain X L^-1 on them and the covariance
// Sigma_ii - X X'.
void ConditionalMap::lift(const std::vector<VariableId>& ids) {
  const std::vector<int> q = rows(ids, true);
  if (q.empty()) return;
  const auto n = std::ssize(q), stem = std::ssize(stem_);
  if (pending_cols_ + n > kPendingColumns) subtract_pending();
  if (n > pending_.cols()) pending_.setZero(far_.mean.size(), n);
  const auto late = pending_.leftCols(pending_cols_);
  Eigen::MatrixXd X = far_.covariance(all(far_.mean.size()), q);
  if (pending_cols_ > 0) X.noalias() -= late * late(q, Eigen::all).transpose();
  const Eigen::MatrixXd Sigma_q = X(q, Eigen::all);
  const Eigen::LLT<Eigen::MatrixXd> llt(Sigma_q);
  if (llt.info() != Eigen::Success) {
    throw Diverged("the covariance of a landmark that returns is not positive definite");
  }
  const Eigen::MatrixXd K_q = far_.K(q, Eigen::seqN(0, stem));
  const Eigen::VectorXd mean_q = far_.mean(q);

  std::vector<int> own;
  for (const VariableId id : ids) {
    if (!places_.at(id).is_far) continue;
    const int row = near_.add(kDim);
    for (int k = 0; k < kDim; ++k) own.push_back(row + k);
  }
  near_.mean(own) = mean_q + K_q * near_.mean(stem_);
  near_.K(own, Eigen::all) = K_q * near_.K(stem_, Eigen::all);
  const std::vector<int> everything = all(near_.mean.size());
  Eigen::MatrixXd cross = K_q * near_.covariance(stem_, everything);
  cross(Eigen::all, own) = Sigma_q + cross(Eigen::all, stem_) * K_q.transpose();
  for (Eigen::Index i = 0; i < n; ++i) {
    const int row = own[static_cast<std::size_t>(i)];
    near_.Sigma.row(row).head(row + 1) = cross.row(i).head(row + 1);
    near_.Sigma.col(row).tail(near_.mean.size() - row) =
        cross.row(i).tail(near_.mean.size() - row).transpose();
  }

  for (const int row : q) X.row(row).setZero();
  llt.matrixU().solveInPlace<Eigen::OnTheRight>(X);
  pending_.middleCols(pending_cols_, n) = X;
  pending_cols_ += static_cast<int>(n);
  llt.matrixL().solveInPlace<Eigen::OnTheRight>(X);  // the gain
  for (std::size_t i = 0; i < q.size(); i += kDim) {
    far_.clear(q[i]);
    pending_.middleRows<kDim>(q[i]).leftCols(pending_cols_).setZero();
    far_.vacant.push_back(q[i]);
  }
  far_.mean.noalias() -= X * mean_q;
  far_.K.leftCols(stem).noalias() -= X * K_q;
  if (far_.K.cols() < stem + n) {
    far_.K.conservativeResize(Eigen::NoChange, stem + std::max<Eigen::Index>(n, kPendingColumns));
  }
  far_.K.middleCols(stem, n) = X;
  stem_.insert(stem_.end(), own.begin(), own.end());
  auto row = own.begin();
  for (const VariableId id : ids) {
    Place& place = places_.at(id);
    if (!place.is_far) continue;
    place = {false, *row};
    row += kDim;
  }
}

// The same within near.
ConditionalMap::Reactivated ConditionalMap::reactivate(const std::vector<VariableId>& ids) {
  lift(ids);
  const std::vector<int> p = rows(ids, false);
  const auto n = static_cast<Eigen::Index>(p.size());
  Reactivated back{near_.mean(p), near_.K(p, Eigen::all), {}};
  const Eigen::LLT<Eigen::MatrixXd> of_covariance(near_.covariance(p, p));
  const Eigen::LLT<Eigen::MatrixXd> of_information(
      of_covariance.solve(Eigen::MatrixXd::Identity(n, n)));
  if (of_covariance.info() != Eigen::Success || of_information.info() != Eigen::Success) {
    throw Diverged("the covariance of a landmark that returns is not positive definite");
  }
  back.U = of_information.matrixU();
  Eigen::MatrixXd X = near_.covariance(all(near_.mean.size()), p);
  forget_rows(ids);
  for (const int row : p) X.row(row).setZero();
  of_covariance.matrixU().solveInPlace<Eigen::OnTheRight>(X);
  near_.Sigma.selfadjointView<Eigen::Lower>().rankUpdate(X, -1.0);
  of_covariance.matrixL().solveInPlace<Eigen::OnTheRight>(X);
  Eigen::MatrixXd K(near_.mean.size(), n + near_.K.cols());
  K.leftCols(n) = X;
  K.rightCols(near_.K.cols()) = near_.K - X * back.K;
  near_.K = std::move(K);
  // What is far goes on to depend on these: now on the active ones.
  for (Eigen::Index i = 0; i < n; ++i) {
    const int row = p[static_cast<std::size_t>(i)];
    if (std::ranges::find(stem_, row) == stem_.end()) continue;
    near_.mean(row) = back.mean(i);
    near_.K(row, i) = 1.0;
  }
  if (empty()) *this = {};
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

void ConditionalMap::relinearise(const MarginalPrior& prior) {
  if (empty()) return;
  near_.mean += near_.K * prior.difference();
  prior.transport(near_.K);
}

void ConditionalMap::relinearise(const MarginalPrior& prior, int total) {
  Eigen::MatrixXd K = std::move(near_.K);
  near_.K.setZero(near_.mean.size(), total);
  if (empty()) return;
  near_.mean.noalias() += K * prior.difference();
  prior.transport(K);
  for (const MarginalPrior::Block& block : prior.blocks()) {
    near_.K.middleCols(block.variable->column, block.dim()) =
        K.middleCols(block.offset, block.dim());
  }
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
