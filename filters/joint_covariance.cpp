#include "slammot/filters/joint_covariance.h"

#include <algorithm>

namespace slammot {

void JointCovariance::reserve(int size) {
  if (size <= storage_.rows()) return;
  const int capacity = std::max(size, static_cast<int>(storage_.rows()) * 3 / 2 + 64);
  Eigen::MatrixXd larger(capacity, capacity);
  larger.topLeftCorner(size_, size_) = P();
  storage_.swap(larger);
}

StateBlock JointCovariance::append(const std::vector<Dependence>& dependences,
                                   const Eigen::MatrixXd& R) {
  const int dim = static_cast<int>(R.rows());
  reserve(size_ + dim);
  const StateBlock added{size_, dim};
  Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(dim, size_);
  for (const Dependence& d : dependences) cross.noalias() += d.J * rows(d.on);
  Eigen::MatrixXd own = R;
  for (const Dependence& d : dependences) {
    own += cross.middleCols(d.on.offset, d.on.dim) * d.J.transpose();
  }
  storage_.block(size_, 0, dim, size_) = cross;
  storage_.block(0, size_, size_, dim) = cross.transpose();
  storage_.block(size_, size_, dim, dim) = 0.5 * (own + own.transpose());
  size_ += dim;
  return added;
}

void JointCovariance::transform(StateBlock b, const Eigen::MatrixXd& J) {
  auto columns = storage_.block(0, b.offset, size_, b.dim);
  const Eigen::MatrixXd own = J * block(b, b) * J.transpose();
  const Eigen::MatrixXd moved = columns * J.transpose();
  columns = moved;
  rows(b) = moved.transpose();
  storage_.block(b.offset, b.offset, b.dim, b.dim) = 0.5 * (own + own.transpose());
}

void JointCovariance::propagate(StateBlock b, const Eigen::MatrixXd& F, const Eigen::MatrixXd& Q) {
  transform(b, F);
  storage_.block(b.offset, b.offset, b.dim, b.dim) += Q;
}

void JointCovariance::add_dependence(StateBlock b, const Eigen::MatrixXd& B) {
  // P + B P_b' + P_b B' + B P_bb B' = P + B C' + C B'
  const Eigen::MatrixXd C = cols(b) + 0.5 * B * block(b, b);
  P().noalias() += B * C.transpose();
  P().noalias() += C * B.transpose();
}

void JointCovariance::subtract_outer(const Eigen::MatrixXd& W) {
  auto P_n = P();
  P_n.selfadjointView<Eigen::Lower>().rankUpdate(W, -1.0);
  P_n.triangularView<Eigen::StrictlyUpper>() = P_n.transpose();
}

void JointCovariance::remove(const std::vector<StateBlock>& blocks) {
  if (blocks.empty()) return;
  std::vector<StateBlock> kept;
  int begin = 0;
  for (const StateBlock& b : blocks) {
    if (b.offset > begin) kept.push_back({begin, b.offset - begin});
    begin = b.end();
  }
  if (begin < size_) kept.push_back({begin, size_ - begin});
  int column = 0;
  for (const StateBlock& c :
       kept) {  // what is written lies left of and above what is still to read
    for (int j = 0; j < c.dim; ++j, ++column) {
      int row = 0;
      for (const StateBlock& r : kept) {
        const double* from = &storage_(r.offset, c.offset + j);
        std::copy(from, from + r.dim, &storage_(row, column));
        row += r.dim;
      }
    }
  }
  size_ = column;
}

int shifted(int offset, const std::vector<StateBlock>& removed) {
  int shift = 0;
  for (const StateBlock& b : removed) shift += b.offset < offset ? b.dim : 0;
  return offset - shift;
}

}  // namespace slammot
