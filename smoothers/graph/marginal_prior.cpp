#include "smoothers/graph/marginal_prior.h"

#include <algorithm>

namespace slammot {

namespace {

// R'R, by panels of columns; rows below the last that is not zero (R is a triangle) are left out.
Eigen::MatrixXd gram(const Eigen::MatrixXd& R) {
  constexpr Eigen::Index kPanel = 64;
  const Eigen::Index n = R.cols();
  Eigen::MatrixXd RtR(n, n);
  for (Eigen::Index c = 0; c < n; c += kPanel) {
    const Eigen::Index width = std::min(kPanel, n - c);
    Eigen::Index rows = R.rows();
    while (rows > 0 && (R.row(rows - 1).segment(c, width).array() == 0.0).all()) --rows;
    RtR.block(c, c, n - c, width).noalias() =
        R.topRightCorner(rows, n - c).transpose() * R.block(0, c, rows, width);
  }
  RtR.triangularView<Eigen::StrictlyUpper>() = RtR.transpose();
  return RtR;
}

}  // namespace

const MarginalPrior::Block* MarginalPrior::find(VariableId id) const {
  const auto found = std::find_if(blocks_.begin(), blocks_.end(),
                                  [&](const Block& b) { return b.variable->id == id; });
  return found == blocks_.end() ? nullptr : &*found;
}

Eigen::VectorXd MarginalPrior::difference(Field b) const {
  Eigen::VectorXd d(cols());
  for (const Block& block : blocks_) {
    const Variable& v = *block.variable;
    d.segment(block.offset, v.dim()) = minus(v.manifold, v.*b, block.x0);
  }
  return d;
}

double MarginalPrior::square(Field b) const {
  return cols() == 0 ? 0.0 : (R_ * difference(b) + r_).squaredNorm();
}

Eigen::VectorXd MarginalPrior::residual() const { return R_ * difference() + r_; }

Eigen::MatrixXd MarginalPrior::jacobian() const {
  Eigen::MatrixXd J = R_;
  transport(J);
  return J;
}

void MarginalPrior::transport(Eigen::Ref<Eigen::MatrixXd> A) const {
  for (const Block& block : blocks_) {
    if (!turns(block)) continue;
    auto columns = A.middleCols(block.offset, block.dim());
    columns = (columns * slammot::transport(*block.variable, block.x0)).eval();
  }
}

void MarginalPrior::transport_both(Eigen::Ref<Eigen::MatrixXd> M) const {
  for (const Block& block : blocks_) {
    if (!turns(block)) continue;
    const SmallMatrix T = slammot::transport(*block.variable, block.x0);
    auto columns = M.middleCols(block.offset, block.dim());
    columns = (columns * T).eval();
    auto rows = M.middleRows(block.offset, block.dim());
    rows = (T.transpose() * rows).eval();
  }
}

void MarginalPrior::normal_equations(Eigen::Ref<Eigen::MatrixXd> H,
                                     Eigen::Ref<Eigen::VectorXd> g) const {
  H = RtR_;
  g = RtR_ * difference() + R_.transpose() * r_;
  transport_both(H);
  for (const Block& block : blocks_) {
    if (!turns(block)) continue;
    auto part = g.segment(block.offset, block.dim());
    part = (slammot::transport(*block.variable, block.x0).transpose() * part).eval();
  }
}

void MarginalPrior::set(const std::vector<Variable*>& variables, Eigen::MatrixXd R,
                        Eigen::VectorXd r) {
  blocks_.clear();
  R_ = std::move(R);
  r_ = std::move(r);
  RtR_ = gram(R_);
  int offset = 0;
  for (Variable* v : variables) {
    if (first_estimates_ && !v->linearisation_point) v->linearisation_point = v->value;
    blocks_.push_back({v, offset, v->value});
    offset += v->dim();
  }
}

void MarginalPrior::relinearise() {
  if (cols() == 0) return;
  r_ += R_ * difference();
  transport(R_);
  transport_both(RtR_);
  for (Block& block : blocks_) block.x0 = block.variable->value;
}

void MarginalPrior::condition_on_zero(VariableId id) {
  const auto k = blocks_.begin() + (find(id) - blocks_.data());
  const int offset = k->offset, dim = k->dim(), kept = cols() - dim, after = kept - offset;
  r_.noalias() -= R_.middleCols(offset, dim) * k->x0;
  Eigen::MatrixXd R(R_.rows(), kept), RtR(kept, kept);
  R << R_.leftCols(offset), R_.rightCols(after);
  RtR << RtR_.topLeftCorner(offset, offset), RtR_.topRightCorner(offset, after),
      RtR_.bottomLeftCorner(after, offset), RtR_.bottomRightCorner(after, after);
  R_ = std::move(R);
  RtR_ = std::move(RtR);
  for (auto later = blocks_.erase(k); later != blocks_.end(); ++later) later->offset -= dim;
}

void MarginalPrior::join(const std::vector<Variable*>& variables, const Eigen::VectorXd& mean,
                         const Eigen::MatrixXd& K, const Eigen::MatrixXd& U) {
  const Eigen::Index n = mean.size(), m = cols(), rows = R_.rows();
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n + rows, n + m);
  R.topLeftCorner(n, n) = U;
  R.topRightCorner(n, m) = -U * K;
  R.bottomRightCorner(rows, m) = R_;
  Eigen::MatrixXd RtR(n + m, n + m);
  RtR.leftCols(n) = R.transpose() * R.leftCols(n);
  RtR.topRightCorner(n, m) = RtR.bottomLeftCorner(m, n).transpose();
  const auto top = R.topRightCorner(n, m);
  RtR.bottomRightCorner(m, m) = RtR_ + top.transpose() * top;
  R_ = std::move(R);
  RtR_ = std::move(RtR);
  r_ = (Eigen::VectorXd(n + r_.size()) << Eigen::VectorXd::Zero(n), r_).finished();
  std::vector<Block> blocks;
  int offset = 0;
  for (const Variable* v : variables) {
    blocks.push_back({v, offset, mean.segment(offset, v->dim())});
    offset += v->dim();
  }
  for (Block& block : blocks_) block.offset += offset;
  blocks_.insert(blocks_.begin(), blocks.begin(), blocks.end());
}

}  // namespace slammot
