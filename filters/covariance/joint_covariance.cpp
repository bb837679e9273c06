#include "filters/covariance/joint_covariance.h"

#include <algorithm>

namespace slammot {

namespace {

using Block = JointCovariance::Block;

Block symmetric(const Block& M) { return 0.5 * (M + M.transpose()); }

int dim_of(std::initializer_list<StateBlock> b) {
  int dim = 0;
  for (const StateBlock& block : b) dim += block.dim;
  return dim;
}

// The rows b of a matrix with the state's rows.
Block rows_of(std::initializer_list<StateBlock> b, Eigen::Ref<const Eigen::MatrixXd> x) {
  Block rows(dim_of(b), x.cols());
  int row = 0;
  for (const StateBlock& block : b) {
    rows.middleRows(row, block.dim) = x.middleRows(block.offset, block.dim);
    row += block.dim;
  }
  return rows;
}

}  // namespace

void JointCovariance::reserve(int size) {
  if (size <= storage_.rows()) return;
  int capacity = std::max(size, static_cast<int>(storage_.rows()) * 3 / 2 + 64);
  capacity += 8 - capacity % 16 +
              (capacity % 16 > 8 ? 16 : 0);  // no power of two: rows would share cache sets
  Eigen::MatrixXd larger(capacity, capacity);
  larger.topLeftCorner(size_, size_) = storage_.topLeftCorner(size_, size_);
  storage_.swap(larger);
}

Eigen::MatrixXd JointCovariance::dense() const {
  return storage_.topLeftCorner(size_, size_).selfadjointView<Eigen::Upper>();
}

JointCovariance::Block JointCovariance::block(StateBlock a, StateBlock b) const {
  if (a.end() <= b.offset) return storage_.block(a.offset, b.offset, a.dim, b.dim);
  if (b.end() <= a.offset) return storage_.block(b.offset, a.offset, b.dim, a.dim).transpose();
  Block result(a.dim, b.dim);
  for (int j = 0; j < b.dim; ++j) {
    for (int i = 0; i < a.dim; ++i) {
      const int row = a.offset + i, column = b.offset + j;
      result(i, j) = storage_(std::min(row, column), std::max(row, column));
    }
  }
  return result;
}

void JointCovariance::columns(StateBlock b, Eigen::Ref<Eigen::MatrixXd> out) const {
  out.topRows(b.offset) = storage_.block(0, b.offset, b.offset, b.dim);
  out.middleRows(b.offset, b.dim) = block(b, b);
  for (int j = b.end(); j < size_; ++j) {  // P's columns outermost: each is far from the next
    const double* column = &storage_(b.offset, j);
    for (int k = 0; k < b.dim; ++k) out(j, k) = column[k];
  }
}

void JointCovariance::add_columns(StateBlock b, const Eigen::Matrix<double, 2, 3>& J,
                                  Eigen::Ref<Eigen::MatrixX2d> out) const {
  const auto above = storage_.block<Eigen::Dynamic, 3>(0, b.offset, b.offset, 3);
  for (int k = 0; k < 2; ++k) {
    out.col(k).head(b.offset) +=
        J(k, 0) * above.col(0) + J(k, 1) * above.col(1) + J(k, 2) * above.col(2);
  }
  out.middleRows<3>(b.offset) += block(b, b) * J.transpose();
  double* const out_0 = out.col(0).data();
  double* const out_1 = out.col(1).data();
  for (int j = b.end(); j < size_; ++j) {
    const double* const p = &storage_(b.offset, j);
    out_0[j] += J(0, 0) * p[0] + J(0, 1) * p[1] + J(0, 2) * p[2];
    out_1[j] += J(1, 0) * p[0] + J(1, 1) * p[1] + J(1, 2) * p[2];
  }
}

void JointCovariance::gather(std::initializer_list<StateBlock> b) {
  gathered_.resize(size_, dim_of(b));
  int column = 0;
  for (const StateBlock& c : b) {
    columns(c, (*gathered_).middleCols(column, c.dim));
    column += c.dim;
  }
}

void JointCovariance::scatter(std::initializer_list<StateBlock> b, const Block& own) {
  int column = 0;
  for (const StateBlock& c : b) {
    const auto values = (*gathered_).middleCols(column, c.dim);
    const int after = size_ - c.end();
    storage_.block(0, c.offset, c.offset, c.dim) = values.topRows(c.offset);
    storage_.block(c.offset, c.end(), c.dim, after) = values.bottomRows(after).transpose();
    column += c.dim;
  }
  int row = 0;
  for (const StateBlock& r : b) {
    column = 0;
    for (const StateBlock& c : b) {
      if (r.offset <= c.offset) {
        storage_.block(r.offset, c.offset, r.dim, c.dim) = own.block(row, column, r.dim, c.dim);
      }
      column += c.dim;
    }
    row += r.dim;
  }
}

StateBlock JointCovariance::append(const std::vector<Dependence>& dependences, const Block& R) {
  const int dim = static_cast<int>(R.rows());
  reserve(size_ + dim);
  const StateBlock added{size_, dim};
  auto cross = storage_.block(0, size_, size_, dim);
  cross.setZero();
  for (const Dependence& d : dependences) {
    gathered_.resize(size_, d.on.dim);
    columns(d.on, *gathered_);
    cross.noalias() += *gathered_ * d.J.transpose();
  }
  Block own = R;
  for (const Dependence& d : dependences) own += d.J * cross.middleRows(d.on.offset, d.on.dim);
  storage_.block(size_, size_, dim, dim) = symmetric(own);
  size_ += dim;
  return added;
}

void JointCovariance::assign(StateBlock b, const Eigen::MatrixXd& cross, const Block& own) {
  gathered_.resize(size_, b.dim);
  *gathered_ = cross;
  scatter({b}, own);
}

void JointCovariance::add(StateBlock a, StateBlock b, const Block& M) {
  if (a.offset < b.offset) {
    storage_.block(a.offset, b.offset, a.dim, b.dim) += M;
  } else {
    storage_.block(b.offset, a.offset, b.dim, a.dim) += M.transpose();
  }
}

// By runs of columns, each down to the diagonal.
void JointCovariance::add_product(Eigen::Ref<const Eigen::MatrixXd> A,
                                  Eigen::Ref<const Eigen::MatrixXd> B) {
  constexpr int kRun = 128;
  for (int first = 0; first < size_; first += kRun) {
    const int run = std::min(kRun, size_ - first), end = first + run;
    storage_.block(0, first, end, run).noalias() +=
        A.leftCols(end).transpose() * B.middleCols(first, run);
  }
}

void JointCovariance::propagate(std::initializer_list<StateBlock> b, const Block& F,
                                const Block& Q) {
  gather(b);
  factor_.resize(size_, F.cols());
  factor_.swap(gathered_);
  (*gathered_).noalias() = *factor_ * F.transpose();
  scatter(b, symmetric(F * rows_of(b, *gathered_)) + Q);
}

void JointCovariance::transform(std::initializer_list<StateBlock> b, const Block& J) {
  propagate(b, J, Block::Zero(J.rows(), J.rows()));
}

void JointCovariance::add_dependence(Eigen::Ref<const Eigen::MatrixXd> L,
                                     Eigen::Ref<const Eigen::MatrixXd> M) {
  // P + M (P L)' + (P L) M' + M (L'P L) M' = P + M C' + C M'
  gathered_.resize(size_, L.cols());
  auto C = *gathered_;
  multiply(L, C);
  const Block half = 0.5 * L.transpose().lazyProduct(C);
  C.noalias() += M.lazyProduct(half);
  auto P = storage_.topLeftCorner(size_, size_).selfadjointView<Eigen::Upper>();
  for (Eigen::Index j = 0; j < L.cols(); ++j) P.rankUpdate(M.col(j), C.col(j));
}

void JointCovariance::multiply(Eigen::Ref<const Eigen::MatrixXd> L,
                               Eigen::Ref<Eigen::MatrixXd> out) const {
  const auto P = storage_.topLeftCorner(size_, size_).selfadjointView<Eigen::Upper>();
  for (Eigen::Index j = 0; j < L.cols(); ++j) out.col(j).noalias() = P * L.col(j);
}

void JointCovariance::subtract_outer(Eigen::Ref<const Eigen::MatrixXd> W) {
  subtract_outer({0, size_}, W);
}

// By halves: OpenBLAS's dsyrk with Haswell kernels takes a tenth longer for a whole upper triangle
// of 600 than for its three parts.
void JointCovariance::subtract_outer(StateBlock b, Eigen::Ref<const Eigen::MatrixXd> W) {
  constexpr int kWhole = 320;
  const auto rows = W.middleRows(b.offset, b.dim);
  if (b.dim <= kWhole) {
    storage_.block(b.offset, b.offset, b.dim, b.dim)
        .selfadjointView<Eigen::Upper>()
        .rankUpdate(rows, -1.0);
    return;
  }
  const int half = b.dim / 2, rest = b.dim - half, middle = b.offset + half;
  subtract_outer({b.offset, half}, W);
  storage_.block(b.offset, middle, half, rest).noalias() -=
      rows.topRows(half) * rows.bottomRows(rest).transpose();
  subtract_outer({middle, rest}, W);
}

void JointCovariance::subtract_alone(std::initializer_list<StateBlock> b,
                                     Eigen::Ref<const Eigen::MatrixXd> C, const Block& D) {
  gather(b);
  const Block own = symmetric(rows_of(b, *gathered_) - D);
  *gathered_ -= C;
  scatter(b, own);
}

void JointCovariance::close_gap(StateBlock b) {
  for (int j = b.end(); j < size_; ++j) {  // from left to right, so that nothing is overwritten
    auto to = storage_.col(j - b.dim);
    to.head(b.offset) = storage_.col(j).head(b.offset);
    to.segment(b.offset, j + 1 - b.end()) = storage_.col(j).segment(b.end(), j + 1 - b.end());
  }
  size_ -= b.dim;
}

std::optional<StateBlock> JointCovariance::remove(StateBlock b) {
  size_ -= b.dim;
  if (b.offset == size_) return std::nullopt;
  const StateBlock last{size_, b.dim};
  const int between = last.offset - b.end();
  storage_.block(0, b.offset, b.offset, b.dim) = storage_.block(0, last.offset, b.offset, b.dim);
  storage_.block(b.offset, b.offset, b.dim, b.dim) =
      storage_.block(last.offset, last.offset, b.dim, b.dim);
  storage_.block(b.offset, b.end(), b.dim, between) =
      storage_.block(b.end(), last.offset, between, b.dim).transpose();
  return last;
}

}  // namespace slammot
