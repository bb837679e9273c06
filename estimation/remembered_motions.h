// What the motions of static landmarks would be, were they not held at rest.
//
// They are jointly Gaussian, in information form: J w = j. Of one of them, the others at rest, the
// covariance is J_ii^-1 and the mean J_ii^-1 j_i. Once landmark r is known to move, its motion is
// marginalised and the others are believed given that it may have moved:
//
//   J_ii - J_ir J_rr^-1 J_ri,   j_i - J_ir J_rr^-1 j_r.
//
// So labels of many landmarks are undone in a frame with one factorisation of the belief.
#pragma once

#include <optional>
#include <vector>

#include "estimation/classification.h"

namespace slammot {

class RememberedMotions {
 public:
  // For `landmarks` of them with `dim` numbers each, all zero.
  void reset(Eigen::Index landmarks, int dim);
  // The next one; `y` is its position, of the point parametrisation.
  void add(int track, const Eigen::Vector3d& y);

  std::size_t size() const { return tracks_.size(); }
  int track(std::size_t i) const { return tracks_[i]; }
  const std::vector<int>& tracks() const { return tracks_; }

  // Of those added so far, J and j.
  auto information(std::size_t i, std::size_t k) { return J_.block(row(i), row(k), dim_, dim_); }
  auto vector(std::size_t i) { return j_.segment(row(i), dim_); }

  // What they share through variables that are not known: J := J - C'C, C of their columns.
  void know_given(const Eigen::Ref<const Eigen::MatrixXd>& C) { J_ -= C.transpose() * C; }

  // The marginal of w of the i-th. None where it is not determined. The manager fills in
  // MotionBelief::prior_sigmas and outside; `seen` is w itself, since at w = 0 no depth enters.
  std::optional<MotionBelief> motion(std::size_t i, const LandmarkFunctions& functions) const;

  // The i-th may move. False, and nothing done, where its motion is not determined.
  bool release(std::size_t i);

 private:
  Eigen::Index row(std::size_t i) const { return dim_ * static_cast<Eigen::Index>(i); }

  int dim_ = 0;
  std::vector<int> tracks_;
  std::vector<Eigen::Vector3d> y_;
  Eigen::MatrixXd J_;
  Eigen::VectorXd j_;
};

}  // namespace slammot
