#include "estimation/gate.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numeric>

#include "estimation/estimator.h"

namespace slammot {

namespace {

using Eigen::Index;

Index row(std::size_t i) { return static_cast<Index>(2 * i); }

double squared(const Eigen::Vector2d& nu, const Eigen::Matrix2d& S) {
  return nu.dot(S.inverse() * nu);
}

}  // namespace

void add_pixel_noise(std::span<const Observation> z, double pixel_sigma, GrowingMatrix& S) {
  auto diagonal = (*S).diagonal();
  for (std::size_t i = 0; i < z.size(); ++i) {
    diagonal.segment<2>(row(i)).array() += z[i].variance(pixel_sigma);
  }
}

double pixel_threshold(double probability) { return -2.0 * std::log1p(-probability); }

FrameGate::Block FrameGate::S(std::size_t i, std::size_t j) const {
  return (*S_).block<2, 2>(row(i), row(j));
}

bool FrameGate::accepts_moved(const FrameInnovation& frame, std::size_t i, double moved_px) const {
  const Block moved = moved_px * moved_px * Block::Identity();
  return squared(frame.nu[i], S(i, i) + moved) <= given_others_;
}

void FrameGate::judge(const FrameInnovation& frame) {
  const std::size_t n = frame.z.size();
  S_.resize(row(n), row(n));
  *S_ = (*frame.HPHt).selfadjointView<Eigen::Lower>();
  add_pixel_noise(frame.z, pixel_sigma_, S_);
  is_accepted_.assign(n, 0);
  nis_.resize(n);
  nis_given_others_.resize(n);
  set_.clear();
  asks_alone_ = true;
  for (std::size_t i = 0; i < n; ++i) {
    nis_[i] = squared(frame.nu[i], S(i, i));
    if (accepts_alone(i)) set_.push_back(i);  // NaN does not
  }
  if (std::isfinite(given_others_)) {
    keep_those_that_agree_with_one(frame);
    if (2 * set_.size() < n) begin_with_majority(frame);
  }
  accept(frame);
  drop_worst();
  if (admit_others(frame)) {
    accept(frame);
    drop_worst();
  }
  joint_nis_ = 0.0;
  for (std::size_t k = 0; k < set_.size(); ++k) {
    joint_nis_ += frame.nu[set_[k]].dot((*a_).block<2, 1>(row(k), 0));
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!accepts(i)) nis_given_others_[i] = given_accepted(frame, i);
  }
}

// nu_j given i is nu_j - S_ji S_ii^-1 nu_i, of covariance S_jj - S_ji S_ii^-1 S_ij.
void FrameGate::keep_those_that_agree_with_one(const FrameInnovation& frame) {
  most_.clear();
  for (const std::size_t i : set_) {
    const Block S_inverse = S(i, i).inverse();
    agree_.clear();
    for (const std::size_t j : set_) {
      const Block gain = S(j, i) * S_inverse;
      const Eigen::Vector2d nu = frame.nu[j] - gain * frame.nu[i];
      if (i == j || squared(nu, S(j, j) - gain * S(i, j)) <= given_others_) agree_.push_back(j);
    }
    if (agree_.size() > most_.size()) most_.swap(agree_);
  }
  set_.swap(most_);
}

void FrameGate::begin_with_majority(const FrameInnovation& frame) {
  passing_ = set_;
  set_.resize(frame.z.size());
  std::iota(set_.begin(), set_.end(), std::size_t{0});
  keep_those_that_agree_with_one(frame);
  asks_alone_ = set_.size() < kQuorum || 2 * set_.size() <= frame.z.size();
  if (asks_alone_) set_ = passing_;
}

// All of the set, in a and B.
void FrameGate::accept(const FrameInnovation& frame) {
  const Index size = row(set_.size());
  L_.resize(size, size);
  B_.resize(size, size);
  a_.resize(size, 1);
  auto L = *L_, B = *B_, a = *a_;
  for (std::size_t k = 0; k < set_.size(); ++k) {
    is_accepted_[set_[k]] = 1;
    a.block<2, 1>(row(k), 0) = frame.nu[set_[k]];
    for (std::size_t l = 0; l < set_.size(); ++l) {
      L.block<2, 2>(row(k), row(l)) = S(set_[k], set_[l]);
    }
  }
  Eigen::Ref<Eigen::MatrixXd> S = L;
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(S);
  if (llt.info() != Eigen::Success) {
    throw Diverged("the innovation covariance is not positive definite");
  }
  B.setIdentity();
  llt.solveInPlace(B);
  llt.solveInPlace(a);
}

void FrameGate::drop_worst() {
  const auto B = *B_, a = *a_;
  for (;;) {
    std::size_t worst = set_.size();
    double largest = given_others_;
    for (std::size_t k = 0; k < set_.size(); ++k) {
      if (!accepts(set_[k])) continue;
      double& nis = nis_given_others_[set_[k]];
      nis = squared(a.block<2, 1>(row(k), 0), B.block<2, 2>(row(k), row(k)));
      if (nis <= largest) continue;
      largest = nis;
      worst = k;
    }
    if (worst == set_.size()) return;
    drop(worst);
  }
}

// Without i, B is B - B_:i B_ii^-1 B_i: and a is a - B_:i B_ii^-1 a_i. Its own rows stay, as zeros.
void FrameGate::drop(std::size_t k) {
  auto B = *B_, a = *a_;
  const Index i = row(k);
  columns_.resize(B.rows(), 2);
  gain_.resize(B.rows(), 2);
  auto columns = *columns_, gain = *gain_;
  columns = B.middleCols<2>(i);
  gain.noalias() = columns * Block(columns.middleRows<2>(i)).inverse();
  const Eigen::Vector2d a_i = a.block<2, 1>(i, 0);
  a.noalias() -= gain * a_i;
  B.noalias() -= gain * columns.transpose();
  B.middleCols<2>(i).setZero();
  B.middleRows<2>(i).setZero();
  a.middleRows<2>(i).setZero();
  is_accepted_[set_[k]] = 0;
}

// nu_i - S_i: a given the accepted, of covariance S_ii - S_i: B S_:i.
double FrameGate::given_accepted(const FrameInnovation& frame, std::size_t i) const {
  const auto B = *B_, a = *a_;
  Eigen::Vector2d nu = frame.nu[i];
  Block covariance = S(i, i);
  for (std::size_t k = 0; k < set_.size(); ++k) {
    const Block S_ik = S(i, set_[k]);
    nu -= S_ik * a.block<2, 1>(row(k), 0);
    Block gain = Block::Zero();
    for (std::size_t l = 0; l < set_.size(); ++l) {
      gain += B.block<2, 2>(row(k), row(l)) * S(set_[l], i);
    }
    covariance -= S_ik * gain;
  }
  return squared(nu, covariance);
}

// Of those that pass on their own.
bool FrameGate::admit_others(const FrameInnovation& frame) {
  agree_.clear();
  for (std::size_t i = 0; i < frame.z.size(); ++i) {
    const bool passes =
        accepts(i) || (accepts_alone(i) && given_accepted(frame, i) <= given_others_);
    if (passes) agree_.push_back(i);
  }
  std::size_t before = 0;
  for (const std::size_t i : set_) before += accepts(i) ? 1 : 0;
  if (agree_.size() == before) return false;
  set_.swap(agree_);
  return true;
}

}  // namespace slammot
