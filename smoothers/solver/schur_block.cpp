#include "smoothers/solver/schur_block.h"

#include <algorithm>

#include "estimation/estimator.h"

namespace slammot {

Place SchurBlock::add_variable(int block, int dim, bool is_noise) {
  Eigen::Index& end = is_noise ? noise_dim_ : dim_;
  const Place place{is_noise ? Place::Part::kNoises : Place::Part::kStates, block,
                    static_cast<int>(end), dim};
  end += dim;
  return place;
}

bool SchurBlock::has_noise(Places places) {
  return std::any_of(places.begin(), places.end(),
                     [](const Place* p) { return p->part == Place::Part::kNoises; });
}

void SchurBlock::tie(Places places, Eigen::Index rows) {
  if (places.size() > 1 && has_noise(places)) rows_ += rows;
  for (const Place* p : places) {
    if (p->part == Place::Part::kCore) ties_[p->offset] = p->dim;
  }
}

void SchurBlock::begin() {
  for (auto& [offset, column] : ties_) {
    const int dim = column;
    column = static_cast<int>(columns_.size());
    for (int i = 0; i < dim; ++i) columns_.push_back(offset + i);
  }
  const auto n = static_cast<Eigen::Index>(columns_.size());
  N_.setZero(rows_, noise_dim_);
  X_.setZero(rows_, dim_ + n);
  r_.setZero(rows_);
  p_.setZero(noise_dim_);
  V_.setZero(dim_, dim_);
  W_.setZero(dim_, n);
  reduced_g_.setZero(dim_);
  g_.states.setZero(dim_);
  g_.noises.setZero(noise_dim_);
}

void SchurBlock::add(const Factor& factor, Places places) {
  if (!has_noise(places)) return add_row_of_states(factor, places);
  if (places.size() == 1) return add_prior_of_noise(factor, *places.front());
  add_row_with_noise(factor, places);
}

void SchurBlock::add_prior_of_noise(const Factor& factor, const Place& place) {
  p_.segment(place.offset, place.dim) += factor.r;
  g_.noises.segment(place.offset, place.dim) += factor.r;
}

void SchurBlock::add_row_with_noise(const Factor& factor, Places places) {
  const Eigen::Index rows = factor.r.size();
  r_.segment(row_, rows) = factor.r;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& p = *places[i];
    const auto J = factor.jacobian(i);
    if (p.part == Place::Part::kNoises) {
      N_.block(row_, p.offset, rows, p.dim) = J;
      g_.noises.segment(p.offset, p.dim) += J.transpose().lazyProduct(factor.r);
    } else if (p.part == Place::Part::kStates) {
      X_.block(row_, p.offset, rows, p.dim) = J;
      g_.states.segment(p.offset, p.dim) += J.transpose().lazyProduct(factor.r);
    } else {
      X_.block(row_, dim_ + ties_.at(p.offset), rows, p.dim) += J;
    }
  }
  row_ += rows;
}

void SchurBlock::add_row_of_states(const Factor& factor, Places places) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& a = *places[i];
    if (a.part != Place::Part::kStates) continue;
    const auto J_t = factor.jacobian(i).transpose();
    g_.states.segment(a.offset, a.dim) += J_t.lazyProduct(factor.r);
    reduced_g_.segment(a.offset, a.dim) += J_t.lazyProduct(factor.r);
    for (std::size_t j = 0; j < places.size(); ++j) {
      const Place& b = *places[j];
      if (b.part == Place::Part::kStates) {
        V_.block(a.offset, b.offset, a.dim, b.dim) += J_t.lazyProduct(factor.jacobian(j));
      } else {
        W_.middleCols(ties_.at(b.offset), b.dim).middleRows(a.offset, a.dim) +=
            J_t.lazyProduct(factor.jacobian(j));
      }
    }
  }
}

void SchurBlock::eliminate_noises() {
  Eigen::MatrixXd M = Eigen::MatrixXd::Identity(rows_, rows_);
  const Eigen::MatrixXd N_D = N_ * D_.cwiseInverse().asDiagonal();
  M.noalias() += N_D * N_.transpose();
  M_.compute(M);
  if (M_.info() != Eigen::Success) {
    throw Diverged("the noise of a landmark in the window is not finite");
  }
  JX_ = X_;
  M_.matrixL().solveInPlace(JX_);
  Jr_ = r_ - N_D * p_;
  M_.matrixL().solveInPlace(Jr_);
  if (dim_ == 0) return;  // BLAS refuses matrices without columns
  const auto J_states = JX_.leftCols(dim_);
  V_.noalias() += J_states.transpose() * J_states;
  W_.noalias() += J_states.transpose() * JX_.rightCols(W_.cols());
  reduced_g_.noalias() += J_states.transpose() * Jr_;
}

void SchurBlock::eliminate(double damping) {
  const Eigen::Index n = W_.cols();
  Eigen::VectorXd squares = V_.diagonal();
  D_ = Eigen::VectorXd::Ones(noise_dim_);
  if (damping > 0.0) D_ += damping * (D_ + N_.colwise().squaredNorm().transpose());
  if (rows_ > 0) {
    squares += X_.leftCols(dim_).colwise().squaredNorm();
    eliminate_noises();
  }
  V_.diagonal() += damping * squares;
  if (dim_ > 0) llt_.compute(V_);
  if (dim_ > 0 && llt_.info() != Eigen::Success) {
    throw Diverged("the states of a landmark in the window are not determined");
  }
  information_.setZero(n, n);
  core_gradient_.setZero(n);
  if (n == 0) return;  // tied to nothing yet
  if (rows_ > 0) {
    const auto J_core = JX_.rightCols(n);
    information_.selfadjointView<Eigen::Lower>().rankUpdate(J_core.transpose());
    core_gradient_.noalias() += J_core.transpose() * Jr_;
  }
  if (dim_ == 0) return;
  const Eigen::MatrixXd LW = llt_.matrixL().solve(W_);
  information_.selfadjointView<Eigen::Lower>().rankUpdate(LW.transpose(), -1.0);
  core_gradient_.noalias() -= LW.transpose() * llt_.matrixL().solve(reduced_g_);
}

SchurBlock::Part SchurBlock::step(const Eigen::VectorXd& core) const {
  const Eigen::VectorXd tied = core(columns_);
  Part part;
  part.states.resize(dim_);
  if (dim_ > 0) part.states = -llt_.solve(reduced_g_ + W_ * tied);
  part.noises = -p_;
  if (rows_ > 0) {
    Eigen::VectorXd rows = Jr_ + JX_.rightCols(tied.size()) * tied;
    if (dim_ > 0) rows += JX_.leftCols(dim_) * part.states;
    part.noises -= N_.transpose() * M_.matrixU().solve(rows);
  }
  part.noises.array() /= D_.array();
  return part;
}

Eigen::MatrixXd SchurBlock::covariance(const Eigen::MatrixXd& E_states,
                                       const Eigen::MatrixXd& E_noises,
                                       Eigen::Ref<Eigen::MatrixXd> core) const {
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(core.cols(), core.cols());
  Eigen::MatrixXd E = E_states;
  if (rows_ > 0) {
    const Eigen::MatrixXd E_D = D_.cwiseInverse().asDiagonal() * E_noises;
    Eigen::MatrixXd Y = N_ * E_D;
    M_.matrixL().solveInPlace(Y);
    P += E_noises.transpose() * E_D - Y.transpose() * Y;
    if (dim_ > 0) E -= JX_.leftCols(dim_).transpose() * Y;
    core -= JX_.rightCols(core.rows()).transpose() * Y;
  } else if (noise_dim_ > 0) {
    P += E_noises.transpose() * D_.cwiseInverse().asDiagonal() * E_noises;
  }
  if (dim_ == 0) return P;
  const Eigen::MatrixXd X = llt_.solve(E);
  core -= W_.transpose() * X;
  return P + E.transpose() * X;
}

}  // namespace slammot
