// The NIS of a measurement given all others of the graph, whether it is one of the graph's or not.
//
// With the core fixed, a landmark's own variables leave its pixels the residuals e, of covariance P
// (landmark_block.h), and e moves with the core by B = P J. For pixel i that the graph holds,
//
//   e_i ~ N(0, P_ii - B_i Sigma B_i'),   NIS = e_i' (P_ii - B_i Sigma B_i')^-1 e_i,
//
// where Sigma is the core's covariance. One that it does not hold enters its landmark's block, but
// not Sigma. Its innovation given the others is then P_ii^-1 e_i, of covariance
// P_ii^-1 + P_ii^-1 B_i Sigma B_i' P_ii^-1, so that the NIS is the same with a plus.
#pragma once

#include "smoothers/solver/normal_equations.h"

namespace slammot {

class GivenOthers {
 public:
  // `pixel` by its place among the block's; `e` its residual at the optimum.
  void add(const NormalEquations& equations, const LandmarkBlock& block, int pixel,
           const Eigen::Vector2d& e, bool is_held);

  // Of all that was added since the last call, in that order; factorised by `equations`.
  std::vector<double> nis(const NormalEquations& equations);

 private:
  struct Tested {
    Eigen::Matrix2d P;
    Eigen::Vector2d e;
    bool is_held = true;
  };
  std::vector<Tested> tested_;
  std::vector<double> columns_;  // B' of each
};

}  // namespace slammot
