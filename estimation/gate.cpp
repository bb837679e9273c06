#include "estimation/gate.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "estimation/estimator.h"
#include "models/lapack.h"

namespace slammot {

namespace {

using Eigen::Index;

Index row(std::size_t i) { return static_cast<Index>(2 * i); }

double squared(const Eigen::Vector2d& nu, const Eigen::Matrix2d& S) {
  return nu.dot(S.inverse() * nu);
}

// Past the measurements of the landmark that is measured at i.
std::size_t end_of_landmark(const FrameInnovation& frame, std::size_t i) {
  std::size_t end = i + 1;
  while (end < frame.z.size() && frame.z[end].track == frame.z[i].track) ++end;
  return end;
}

}  // namespace

void add_pixel_noise(std::span<const Observation> z, double pixel_sigma, GrowingMatrix& S) {
  auto diagonal = (*S).diagonal();
  for (std::size_t i = 0; i < z.size(); ++i) {
    diagonal.segment<2>(row(i)).array() += z[i].variance(pixel_sigma);
  }
}

double pixel_threshold(double probability) { return -2.0 * std::log1p(-probability); }

double log_chi_square_tail(double x, int n) {
  double term = 1.0, sum = 0.0;
  for (int k = 0; k < n; ++k) {
    sum += term;
    term *= 0.5 * x / (k + 1);
  }
  return -0.5 * x + std::log(sum);
}

double as_of_one_pixel(double nis, int pixels) {
  return pixels == 1 ? nis : -2.0 * log_chi_square_tail(nis, pixels);
}

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
  judge_alone(frame);
  if (std::isfinite(given_others_)) {
    keep_those_that_agree_with_one(frame);
    if (2 * set_.size() < n) begin_with_majority(frame);
  }
  accept(frame);
  drop_worst(frame);
  if (admit_others(frame)) {
    accept(frame);
    drop_worst(frame);
  }
  joint_nis_ = 0.0;
  for (std::size_t k = 0; k < set_.size(); ++k) {
    joint_nis_ += frame.nu[set_[k]].dot((*a_).block<2, 1>(row(k), 0));
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!accepts(i)) nis_given_others_[i] = given_accepted(frame, i);
  }
}

void FrameGate::judge_alone(const FrameInnovation& frame) {
  set_.clear();
  asks_alone_ = true;
  passes_alone_.resize(frame.z.size());
  agrees_with_own_.assign(frame.z.size(), 1);
  for (std::size_t i = 0, end = 0; i < frame.z.size(); i = end) {
    end = end_of_landmark(frame, i);
    for (std::size_t j = i; j < end; ++j) {
      nis_[j] = squared(frame.nu[j], S(j, j));
      passes_alone_[j] = nis_[j] <= alone_ ? 1 : 0;  // NaN does not
    }
    if (end - i > 1) {
      judge_together(frame, i, end);
    } else if (accepts_alone(i)) {
      set_.push_back(i);
    }
  }
}

// The pixels [i, end) of one landmark. Where they do not pass together, that one goes without which
// the others agree best, until they do.
void FrameGate::judge_together(const FrameInnovation& frame, std::size_t i, std::size_t end) {
  landmark_.resize(end - i);
  std::iota(landmark_.begin(), landmark_.end(), i);
  double nis = nis_together(frame, landmark_);
  while (landmark_.size() > 1 && !(nis <= alone_)) {
    std::fill(&agrees_with_own_[i], &agrees_with_own_[end - 1] + 1, char{0});
    std::vector<std::size_t> best;
    for (const std::size_t dropped : landmark_) {
      std::vector<std::size_t> others;
      std::ranges::remove_copy(landmark_, std::back_inserter(others), dropped);
      const double of_others = nis_together(frame, others);
      if (!best.empty() && !(of_others < nis)) continue;
      nis = of_others;
      best.swap(others);
    }
    landmark_.swap(best);
  }
  if (!(nis <= alone_)) return;
  for (const std::size_t j : landmark_) {
    nis_[j] = nis;
    passes_alone_[j] = 1;
    set_.push_back(j);
  }
}

// Of some pixels of one landmark.
double FrameGate::nis_together(const FrameInnovation& frame,
                               std::span<const std::size_t> places) const {
  if (places.size() == 1) return squared(frame.nu[places[0]], S(places[0], places[0]));
  const Index size = row(places.size());
  Eigen::VectorXd nu(size);
  Eigen::MatrixXd S_own(size, size);
  for (std::size_t k = 0; k < places.size(); ++k) {
    nu.segment<2>(row(k)) = frame.nu[places[k]];
    for (std::size_t l = 0; l < places.size(); ++l) {
      S_own.block<2, 2>(row(k), row(l)) = S(places[k], places[l]);
    }
  }
  return as_of_one_pixel(nu.dot(S_own.llt().solve(nu)), static_cast<int>(places.size()));
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
