// The second question of the gate: each landmark given all others that pass.
#include <Eigen/Cholesky>

#include "estimation/estimator.h"
#include "estimation/gate.h"
#include "models/lapack.h"

namespace slammot {

using Eigen::Index;

// All of the set, in a and B.
void FrameGate::accept(const FrameInnovation& frame) {
  const Index size = row(set_.size());
  B_.resize(size, size);
  a_.resize(size, 1);
  nu_.resize(size, 1);
  auto B = *B_, nu = *nu_;
  for (std::size_t k = 0; k < set_.size(); ++k) {
    is_accepted_[set_[k]] = 1;
    nu.block<2, 1>(row(k), 0) = frame.nu[set_[k]];
    for (std::size_t l = 0; l <= k; ++l) {
      B.block<2, 2>(row(k), row(l)) = S(set_[k], set_[l]);
    }
  }
  if (!cholesky_in_place(B)) throw Diverged("the innovation covariance is not positive definite");
  invert_cholesky_in_place(B);
  (*a_).noalias() = B * nu;
}

void FrameGate::drop_worst(const FrameInnovation& frame) {
  for (;;) {
    std::size_t worst = set_.size();
    double largest = given_others_;
    for (std::size_t k = 0; k < set_.size();) {
      take_accepted(frame, k);
      if (landmark_.empty()) continue;
      const double nis = nis_of_landmark();
      for (const std::size_t l : landmark_) nis_given_others_[set_[l]] = nis;
      if (nis <= largest) continue;
      largest = nis;
      worst = worst_of_landmark();
    }
    if (worst == set_.size()) return;
    drop(worst);
  }
}

// The accepted pixels of the landmark at k of the set; k is then past it.
void FrameGate::take_accepted(const FrameInnovation& frame, std::size_t& k) {
  landmark_.clear();
  for (const int track = frame.z[set_[k]].track; k < set_.size() && frame.z[set_[k]].track == track;
       ++k) {
    if (accepts(set_[k])) landmark_.push_back(k);
  }
}

double FrameGate::nis_of_landmark() const {
  if (landmark_.size() == 1) {
    const Index i = row(landmark_.front());
    return squared((*a_).block<2, 1>(i, 0), (*B_).block<2, 2>(i, i));
  }
  const GivenOthers all = landmark_given_others();
  return as_of_one_pixel(all.a.dot(all.nu), static_cast<int>(landmark_.size()));
}

// The innovations of one landmark given all others are B_UU^-1 a_U, of covariance B_UU^-1.
FrameGate::GivenOthers FrameGate::landmark_given_others() const {
  const Index size = row(landmark_.size());
  Eigen::MatrixXd B(size, size);
  Eigen::VectorXd a(size);
  for (std::size_t k = 0; k < landmark_.size(); ++k) {
    a.segment<2>(row(k)) = (*a_).block<2, 1>(row(landmark_[k]), 0);
    for (std::size_t l = 0; l < landmark_.size(); ++l) {
      B.block<2, 2>(row(k), row(l)) = (*B_).block<2, 2>(row(landmark_[k]), row(landmark_[l]));
    }
  }
  const Eigen::MatrixXd covariance = B.llt().solve(Eigen::MatrixXd::Identity(size, size));
  return {a, covariance * a, covariance};
}

// Its pixel that agrees least with the other landmarks.
std::size_t FrameGate::worst_of_landmark() const {
  if (landmark_.size() == 1) return landmark_.front();
  const GivenOthers all = landmark_given_others();
  std::size_t worst = 0;
  double largest = -1.0;
  for (std::size_t k = 0; k < landmark_.size(); ++k) {
    const double nis = squared(Eigen::Vector2d(all.nu.segment<2>(row(k))),
                               Block(all.covariance.block<2, 2>(row(k), row(k))));
    if (nis <= largest) continue;
    largest = nis;
    worst = k;
  }
  return landmark_[worst];
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

// B_ii^-1 a_i has the covariance B_ii^-1: with B_ii = L L', L^-1 a_i has I.
void FrameGate::scale_accepted() {
  scaled_.assign(is_accepted_.size(), Eigen::Vector2d::Zero());
  for (std::size_t k = 0; k < set_.size(); ++k) {
    if (!accepts(set_[k])) continue;
    const Block B_ii = (*B_).block<2, 2>(row(k), row(k));
    const Eigen::Vector2d a_i = (*a_).block<2, 1>(row(k), 0);
    const Eigen::LLT<Block> factor(B_ii);
    // Rounding of many that were dropped.
    if (factor.info() == Eigen::Success) scaled_[set_[k]] = factor.matrixL().solve(a_i);
  }
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

// Where the pixels of a landmark do not agree with each other, only with those that are used.
bool FrameGate::may_come_in(const FrameInnovation& frame, std::size_t i) const {
  if (!accepts_alone(i)) return false;
  if (asks_alone_ && agrees_with_own_[i] == 0) {
    std::vector<std::size_t> own;
    for (std::size_t j = 0; j < frame.z.size(); ++j) {
      if (frame.z[j].track == frame.z[i].track && (j == i || accepts(j))) own.push_back(j);
    }
    if (!(nis_together(frame, own) <= alone_)) return false;
  }
  return given_accepted(frame, i) <= given_others_;
}

bool FrameGate::admit_others(const FrameInnovation& frame) {
  agree_.clear();
  for (std::size_t i = 0; i < frame.z.size(); ++i) {
    if (accepts(i) || may_come_in(frame, i)) agree_.push_back(i);
  }
  std::size_t before = 0;
  for (const std::size_t i : set_) before += accepts(i) ? 1 : 0;
  if (agree_.size() == before) return false;
  set_.swap(agree_);
  return true;
}

}  // namespace slammot
