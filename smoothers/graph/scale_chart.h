// The coordinates in which a marginal prior is a Gaussian.
//
// Pixels say nothing of the scale: n(b) = db/d(log scale). Those that have left the window were
// blind along n where they were linearised, those in it are along n where the estimate is now, and
// in plain coordinates both together seem to measure the scale. So a prior that keeps it is a
// Gaussian in coordinates in which a change of scale is a straight line:
//
//   d(b) = n(b0) lambda + S(-lambda) b - b0,
//
// where S(t) makes a world e^t as large (scale_orbit.h), and lambda(b) is the log of the scale of b
// over that of b0, as static landmarks and a camera's velocity tell it, a mean with weights. With
// l = dlambda/db, l'n(b) = 1, the Jacobian is
//
//   D = M + (n(b0) - n(S(-lambda) b)) l',   M = dS(-lambda)b/db,   so that D n(b) = n(b0)
//
// at every b: what is known of the scale, |R n(b0)|^2, stays as it is while the estimate moves, and
// so does the scale that the prior prefers. Residual and Jacobian are those of one cost. An error
// state with the same purpose: T-ESKF (Tian, Hao & He, arXiv:2510.23359); a filter's:
// filters/gauge.h.
//
// Without the scale d = b [-] b0. Orientations are in their tangent space at b0, D = T there.
#pragma once

#include <vector>

#include "smoothers/variables/variable.h"

namespace slammot {

// Variables belong to the graph that owns the prior, and stay at their address.
struct PriorBlock {
  const Variable* variable = nullptr;
  int offset = 0;  // first column in R
  SmallVector x0;
  double weight = 0.0;  // in lambda; all add up to one, or to zero: then nothing tells the scale

  int dim() const { return variable->dim(); }
};

class ScaleChart {
 public:
  ScaleChart(bool keeps_scale, bool fixed_points)
      : keeps_scale_(keeps_scale), turns_(!fixed_points) {}

  bool keeps_scale() const { return keeps_scale_; }

  // At b, `value(i)` being block i of it. All that follows is of this b.
  template <typename Value>
  void bend(const std::vector<PriorBlock>& blocks, int cols, Value&& value) {
    start(cols);
    if (keeps_scale_) {
      for (std::size_t i = 0; i < blocks.size(); ++i) tell(blocks[i], value(i));
    }
    for (std::size_t i = 0; i < blocks.size(); ++i) bend(blocks[i], value(i));
  }

  const Eigen::VectorXd& difference() const { return d_; }  // d(b)
  double lambda() const { return lambda_; }
  const Eigen::VectorXd& gradient() const { return l_; }  // l

  // These columns, which are no part of lambda, are no more.
  void erase(int offset, int dim);

  void apply(Eigen::Ref<Eigen::MatrixXd> A) const;             // A := A D
  void apply_transposed(Eigen::Ref<Eigen::VectorXd> g) const;  // g := D'g
  // G := D'G D, where G is symmetric and stored as a whole.
  void bend_gram(Eigen::Ref<Eigen::MatrixXd> G) const;
  // The first column that has a part in lambda, or `cols`.
  int first_told() const { return first_told_; }

  // Weighs what tells the scale, static landmarks and velocities: `information(block)` is H of a
  // block, the others given.
  template <typename Information>
  void weigh(std::vector<PriorBlock>& blocks, Information&& information) const {
    for (PriorBlock& b : blocks)
      b.weight = keeps_scale_ && tells(b) ? weight(b, information(b)) : 0.0;
    normalise(blocks);
  }
  // b0 has moved: a landmark beyond infinity tells nothing.
  static void normalise(std::vector<PriorBlock>& blocks);

 private:
  struct Bent {  // a block of M that is not the identity: e I, or 3 x 3
    int offset = 0, dim = 0;
    bool is_matrix = false;
    double factor = 1.0;
    Eigen::Matrix3d M;
  };

  void start(int cols);
  void tell(const PriorBlock& block, const SmallVector& x);
  void bend(const PriorBlock& block, const SmallVector& x);
  static bool tells(const PriorBlock& block);
  static double weight(const PriorBlock& block, const BlockMatrix& information);

  bool keeps_scale_, turns_;
  double lambda_ = 0.0;
  int first_told_ = 0;
  std::vector<Bent> bent_;
  Eigen::VectorXd d_, l_, q_;     // q = n(b0) - n(S(-lambda) b)
  mutable Eigen::VectorXd of_q_;  // scratch
};

}  // namespace slammot
