// The two levels of the conditional map: near is folded into far, and what returns is lifted out.
#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

#include "estimation/estimator.h"
#include "smoothers/graph/conditional_map.h"

namespace slammot {

namespace {

// Columns by which Sigma is late before it is brought up to date.
constexpr int kPendingColumns = 96;

}  // namespace

std::vector<int> ConditionalMap::indices(Eigen::Index count) {
  std::vector<int> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
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
    place.is_far = true;
    place.row = row;
  }
  of_stem.conservativeResizeLike(Eigen::MatrixXd::Zero(far_.mean.size(), stem));
  for (std::size_t i = 0; i < far_rows.size(); ++i) {
    far_.mean(far_rows[i]) = near_.mean(near_rows[i]);
    far_.K.row(far_rows[i]) = near_.K.row(near_rows[i]);
  }
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
  stem_ = indices(n);
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
  Eigen::MatrixXd X = far_.covariance(indices(far_.mean.size()), q);
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
  const std::vector<int> everything = indices(near_.mean.size());
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
    place.is_far = false;
    place.row = *row;
    row += kDim;
  }
}

}  // namespace slammot
