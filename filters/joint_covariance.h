// The covariance P of the joint state, n x n, with room to grow: blocks are appended at births and
// cut out at deaths. Kept full and symmetric.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace slammot {

// A run of rows (and columns) of P.
struct StateBlock {
  int offset = 0;
  int dim = 0;
  int end() const { return offset + dim; }
};

class JointCovariance {
 public:
  int size() const { return size_; }

  auto P() { return storage_.topLeftCorner(size_, size_); }
  auto P() const { return storage_.topLeftCorner(size_, size_); }
  auto rows(StateBlock b) { return storage_.block(b.offset, 0, b.dim, size_); }
  auto cols(StateBlock b) const { return storage_.block(0, b.offset, size_, b.dim); }
  auto block(StateBlock a, StateBlock b) const {
    return storage_.block(a.offset, b.offset, a.dim, b.dim);
  }

  // Appends a block e' = sum_i J_i e_(b_i) + noise: its rows are sum_i J_i P[b_i, :], and its own
  // covariance is J P J' + R.
  struct Dependence {
    StateBlock on;
    Eigen::MatrixXd J;
  };
  StateBlock append(const std::vector<Dependence>& dependences, const Eigen::MatrixXd& R);

  // e_b := F e_b + noise of covariance Q.
  void propagate(StateBlock b, const Eigen::MatrixXd& F, const Eigen::MatrixXd& Q);

  // e_b := J e_b; the change of coordinates after an update (see joint_state.h).
  void transform(StateBlock b, const Eigen::MatrixXd& J);

  // e := e + B e_b for the whole state; B has the state's rows, zero in those of b.
  void add_dependence(StateBlock b, const Eigen::MatrixXd& B);

  // P := P - W W', W n x k, through one symmetric rank-k update.
  void subtract_outer(const Eigen::MatrixXd& W);

  // Cuts out the rows and columns of `blocks`, given in increasing order without overlap.
  void remove(const std::vector<StateBlock>& blocks);

 private:
  void reserve(int size);

  Eigen::MatrixXd storage_;
  int size_ = 0;
};

// Where a row ends up once `removed` (in increasing order) are cut out.
int shifted(int offset, const std::vector<StateBlock>& removed);

}  // namespace slammot
