#include "estimation/gate.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

namespace slammot {

namespace {

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
    diagonal.segment<2>(static_cast<Eigen::Index>(2 * i)).array() += z[i].variance(pixel_sigma);
  }
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
  scale_accepted();
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
  const Eigen::Index size = row(places.size());
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

}  // namespace slammot
