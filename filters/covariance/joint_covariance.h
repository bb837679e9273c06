// The covariance P of the joint state, n x n, with room to grow. Only its upper triangle is stored:
// the newest landmarks, which are measured, mostly stand last, and above the diagonal their columns
// are contiguous.
//
// Blocks are appended at births. After a death the last block of the same size takes the place of
// the one that went, so that nothing else is copied.
#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include "models/growing_matrix.h"

namespace slammot {

// A run of rows (and columns) of P.
struct StateBlock {
  int offset = 0;
  int dim = 0;
  int end() const { return offset + dim; }
};

class JointCovariance {
 public:
  static constexpr int kLargestBlock = 12;
  using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                              kLargestBlock, kLargestBlock>;

  int size() const { return size_; }
  auto diagonal() const { return storage_.diagonal().head(size_); }

  // P, both triangles: a copy.
  Eigen::MatrixXd dense() const;

  // P[a, b], no larger than kLargestBlock: a copy.
  Block block(StateBlock a, StateBlock b) const;

  // P[:, b], n x dim, into `out`.
  void columns(StateBlock b, Eigen::Ref<Eigen::MatrixXd> out) const;

  // out := out + P[:, b] J' for a block of 3, J 2x3: what a measurement takes of a block.
  void add_columns(StateBlock b, const Eigen::Matrix<double, 2, 3>& J,
                   Eigen::Ref<Eigen::MatrixX2d> out) const;

  // Appends a block e' = sum_i J_i e_(b_i) + noise: its rows are sum_i J_i P[b_i, :], and its own
  // covariance is J P J' + R.
  struct Dependence {
    StateBlock on;
    Block J;
  };
  StateBlock append(const std::vector<Dependence>& dependences, const Block& R);

  // P := P + A' B, which must be symmetric.
  void add_product(Eigen::Ref<const Eigen::MatrixXd> A, Eigen::Ref<const Eigen::MatrixXd> B);

  // P[:, b] := cross with its mirror, and P[b, b] := own.
  void assign(StateBlock b, const Eigen::MatrixXd& cross, const Block& own);

  // P[a, b] := P[a, b] + M with its mirror, of two different blocks.
  void add(StateBlock a, StateBlock b, const Block& M);

  // e_b := F e_b + noise of covariance Q, b being these blocks one after the other.
  void propagate(std::initializer_list<StateBlock> b, const Block& F, const Block& Q);

  // e_b := J e_b; the change of coordinates after an update (see joint_state.h).
  void transform(std::initializer_list<StateBlock> b, const Block& J);

  // e := e + M (L'e), for the whole state; L and M are n x k, k small.
  void add_dependence(Eigen::Ref<const Eigen::MatrixXd> L, Eigen::Ref<const Eigen::MatrixXd> M);

  // P L, into `out`.
  void multiply(Eigen::Ref<const Eigen::MatrixXd> L, Eigen::Ref<Eigen::MatrixXd> out) const;

  // P := P - W W', W n x k, through one symmetric rank-k update.
  void subtract_outer(Eigen::Ref<const Eigen::MatrixXd> W);

  // P[:, b] := P[:, b] - C with its mirror, and P[b, b] := P[b, b] - D: what corrects b alone.
  void subtract_alone(std::initializer_list<StateBlock> b, Eigen::Ref<const Eigen::MatrixXd> C,
                      const Block& D);

  // Cuts out a block; the rows behind it move up. Copies all of them: remove() does not.
  void close_gap(StateBlock b);

  // Cuts out a block. Where another then moves into its place, the place that one had before.
  std::optional<StateBlock> remove(StateBlock b);

 private:
  void reserve(int size);
  // P[:, b] into gathered_; from there back, with P[b, b] as given.
  void gather(std::initializer_list<StateBlock> b);
  void scatter(std::initializer_list<StateBlock> b, const Block& own);
  // P[b, b] := P[b, b] - W_b W_b'.
  void subtract_outer(StateBlock b, Eigen::Ref<const Eigen::MatrixXd> W);

  Eigen::MatrixXd storage_;
  int size_ = 0;
  GrowingMatrix gathered_, factor_;
};

}  // namespace slammot
