// The part B of the map that is out of view, whose rows of P an update need not touch: a compressed
// filter (Guivant & Nebot 2001), exact. A is the active part: the camera, and what is measured.
//
// Whatever happens to A between two folds (prediction, update, birth, change of coordinates), the
// passive rows follow by what they had in common with it at the last synchronisation, C = P_A0B:
//
//   x_B = x_B0 + C' l        P_AB = P_Al C        P_BB = P_B0B0 + C' P_ll C
//
// where l, of A0's dimension, is what a smoother calls the adjoint state (Bryson & Frazier 1963):
// its rows of P start as P_Al = I (A = A0), P_ll = 0, with l = 0, and from then on are treated as
// those of any other state, since all that is done to passive rows is linear in them: an update
// with W = P_A: H' L^-T, L L' = S, subtracts W W' and adds W L^-1 nu, here with
//
//   P_lA := P_lA - Y' W'      P_ll := P_ll - Y' Y      l := l + Y' L^-1 nu      Y' = P_lA H' L^-T.
//
// So l stands as a block among the active part's covariance, and no step of the filter knows of it.
// (-P_ll is a covariance: that of what A's measurements told; P_ll itself is none.)
//
// A synchronisation brings C and P_BB up to date, and l back to its start; blocks then move from A
// to B. It costs n_B^2 n_A0. A block b returns without one, as if it had been active since the last
// synchronisation: its rows P_bB join C, and l grows by its adjoint.
#pragma once

#include "filters/covariance/joint_covariance.h"

namespace slammot {

class PassiveMap {
 public:
  int size() const { return covariance_.size(); }
  bool empty() const { return size() == 0; }
  int synchronisations() const { return synchronisations_; }

  // The rows of l in the active part's covariance.
  StateBlock adjoint() const { return adjoint_; }

  // The part of a correction that is of l.
  void correct(Eigen::Ref<const Eigen::VectorXd> dl) { l_ += dl; }

  bool has_correction() const { return !l_.isZero(0.0); }

  // x_B - x_B0: what corrections have moved it by since this was last asked.
  Eigen::VectorXd take_correction();

  // P[:, b], of a passive block: the rows of the active part; P[a, b] of two passive blocks, from
  // it.
  Eigen::MatrixXd columns(const JointCovariance& active, StateBlock b) const;
  JointCovariance::Block block(StateBlock a, StateBlock b, const Eigen::MatrixXd& columns) const;

  // A synchronisation. Of the active rows, all but those of l are listed: `deactivated` ones,
  // blocks of 3, become the last of the passive ones; the others are kept, in their order, l after
  // the first `first`.
  void synchronise(JointCovariance& active, const std::vector<int>& kept,
                   const std::vector<int>& deactivated, int first);

  // Appends a passive block to the active part; its adjoint takes the place of 3 rows after l,
  // which the active part has vacated. The block's passive rows are still to be removed.
  StateBlock reactivate(JointCovariance& active, StateBlock b);

  // As JointCovariance::remove.
  std::optional<StateBlock> remove(StateBlock b);

  // Throws Diverged where the diagonal of P_BB is none of a covariance.
  void check() const;

 private:
  auto cross() const { return cross_.topLeftCorner(adjoint_.dim, size()); }

  JointCovariance covariance_;  // P_B0B0
  Eigen::MatrixXd cross_;       // C, with room for more rows
  StateBlock adjoint_;
  Eigen::VectorXd l_;
  int synchronisations_ = 0;
};

}  // namespace slammot
