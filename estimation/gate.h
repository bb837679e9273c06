// The gate of all estimators: which of a frame's measurements are used.
//
// Each on its own: nu_i' S_ii^-1 nu_i, with S = H P H' + R, against a chi-square
// quantile. What all of a frame share, above all the camera's motion, is in every S_ii, so that
// this alone may let anything pass.
//
// Given the others: with a = S^-1 nu and B = S^-1, the NIS of measurement i given all others is
// a_i' B_ii^-1 a_i (docs/filter.md). An outlier spoils that of its neighbours. So every
// measurement is first believed alone, and the one that most others agree with decides where to
// begin (one-point consensus, Civera et al. 2010). Of those that agree the worst is dropped, given
// all others, until all pass. Then what passes given them comes in.
//
// A landmark that several cameras of a rig measure is judged with all its pixels together: their
// NIS, of two degrees of freedom each, as the value of two that is as probable. Where that is too
// large its worst pixel goes, not the others: a false match of one camera costs no other's. What
// most agree with is asked pixel by pixel.
//
// A camera step of a size met once in twenty frames takes all points beyond a quantile of 95% at
// once. So where fewer than half pass on their own and agree, it is asked which agree with one
// whether or not they pass. If these are the majority, and at least five, none is judged on its own
// in this frame.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <span>
#include <vector>

#include "estimation/options.h"
#include "models/chi_square.h"
#include "models/growing_matrix.h"
#include "models/measurement.h"

namespace slammot {

// The innovations of a frame's measurements under the predicted belief.
struct FrameInnovation {
  std::vector<Observation> z;
  std::vector<Eigen::Vector2d> nu;  // z - h(x) [px]
  // Joint covariance of all h(x), without the pixels' noise [px^2]: 2n x 2n, the lower triangle.
  // In the EKF with N, what the linearisation leaves out (filters/second_order.h).
  GrowingMatrix HPHt;
};

// Fewer that agree may be those of one mover.
inline constexpr std::size_t kQuorum = 5;

// S = H P H' + R: adds R of these measurements, two rows each in their order, to the diagonal.
void add_pixel_noise(std::span<const Observation> z, double pixel_sigma, GrowingMatrix& S);

class FrameGate {
 public:
  FrameGate(const GateOptions& options, double pixel_sigma)
      : alone_(pixel_threshold(options.probability)),
        given_others_(pixel_threshold(options.given_others)),
        pixel_sigma_(pixel_sigma) {}

  // Throws Diverged when S is not positive definite.
  void judge(const FrameInnovation& frame);

  // Of the frame judged last, by the place of the measurement.
  Eigen::Matrix2d S(std::size_t i) const { return S(i, i); }
  bool accepts(std::size_t i) const { return is_accepted_[i] != 0; }
  bool accepts_alone(std::size_t i) const { return !asks_alone_ || passes_alone_[i] != 0; }
  // With those accepted, whether or not it passes on its own. Where `given_others` is not asked,
  // the accepted ones.
  bool agrees(std::size_t i) const {
    return accepts(i) || (std::isfinite(given_others_) && nis_given_others_[i] <= given_others_);
  }
  // On its own; of a landmark's pixels that pass together, all of them, as of one.
  double nis(std::size_t i) const { return nis_[i]; }
  // Given the accepted ones; of one of these, of all accepted pixels of its landmark.
  double nis_given_others(std::size_t i) const { return nis_given_others_[i]; }
  // Of an accepted one: its innovation given all others accepted, in units of which the covariance
  // is the identity.
  Eigen::Vector2d scaled_given_others(std::size_t i) const { return scaled_[i]; }
  // Whether it would pass if its landmark had moved by so many pixels (one sigma, either way).
  bool accepts_moved(const FrameInnovation& frame, std::size_t i, double moved_px) const;
  double joint_nis() const { return joint_nis_; }  // nu' S^-1 nu of all accepted

 private:
  using Block = Eigen::Matrix2d;
  struct GivenOthers {
    Eigen::VectorXd a, nu;
    Eigen::MatrixXd covariance;  // of nu
  };
  static Eigen::Index row(std::size_t i) { return static_cast<Eigen::Index>(2 * i); }
  static double squared(const Eigen::Vector2d& nu, const Block& S) {
    return nu.dot(S.inverse() * nu);
  }
  Block S(std::size_t i, std::size_t j) const;
  void judge_alone(const FrameInnovation& frame);
  void judge_together(const FrameInnovation& frame, std::size_t i, std::size_t end);
  double nis_together(const FrameInnovation& frame, std::span<const std::size_t> places) const;
  void keep_those_that_agree_with_one(const FrameInnovation& frame);
  void begin_with_majority(const FrameInnovation& frame);
  void accept(const FrameInnovation& frame);
  void drop_worst(const FrameInnovation& frame);
  void take_accepted(const FrameInnovation& frame, std::size_t& k);
  double nis_of_landmark() const;
  GivenOthers landmark_given_others() const;
  std::size_t worst_of_landmark() const;
  void drop(std::size_t k);
  void scale_accepted();
  bool may_come_in(const FrameInnovation& frame, std::size_t i) const;
  bool admit_others(const FrameInnovation& frame);
  double given_accepted(const FrameInnovation& frame, std::size_t i) const;

  double alone_, given_others_;  // thresholds
  double pixel_sigma_;
  double joint_nis_ = 0.0;
  bool asks_alone_ = true;
  std::vector<char> is_accepted_, passes_alone_, agrees_with_own_;
  std::vector<double> nis_, nis_given_others_;
  std::vector<Eigen::Vector2d> scaled_;
  std::vector<std::size_t> set_, agree_, most_, passing_;  // places of measurements
  std::vector<std::size_t> landmark_;                      // of one's pixels
  GrowingMatrix S_;                                        // of all
  GrowingMatrix nu_, B_, a_;                               // of the set, in its order
  GrowingMatrix gain_, columns_;
};

}  // namespace slammot
