#include "smoothers/graph/scale_chart.h"

#include <algorithm>
#include <cmath>

namespace slammot {

namespace {

// The log of a ratio, and from half down a straight line.
double log_ratio(double t, double& slope) {
  constexpr double kLeast = 0.5;
  slope = 1.0 / std::max(t, kLeast);
  return t > kLeast ? std::log(t) : std::log(kLeast) + (t - kLeast) / kLeast;
}

double inverse_depth(const PriorBlock& block) {
  return block.variable->orbit.point->inverse_depth(block.x0);
}

// A := A M of three columns.
template <typename Columns>
void turn(Columns A, const Eigen::Matrix3d& M) {
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const Eigen::RowVector3d row = A.row(i) * M;
    A.row(i) = row;
  }
}

}  // namespace

bool ScaleChart::tells(const PriorBlock& block) {
  const Variable& v = *block.variable;
  if (v.is_constrained || v.is_considered) return false;
  if (v.orbit.kind == ScaleOrbit::Kind::kRates) return block.x0.head<3>().squaredNorm() > 0.0;
  return v.orbit.kind == ScaleOrbit::Kind::kPoint && v.tells_scale && inverse_depth(block) > 0.0;
}

// No landmark counts as better known than to a tenth: else few would decide.
double ScaleChart::weight(const PriorBlock& block, const BlockMatrix& information) {
  constexpr double kBest = 0.1;
  const SmallVector n = block.variable->orbit.direction(block.x0);
  const double along = n.dot(information * n);
  return along > 1.0 ? 1.0 / (1.0 / along + kBest * kBest) : 0.0;
}

void ScaleChart::normalise(std::vector<PriorBlock>& blocks) {
  double sum = 0.0;
  for (PriorBlock& b : blocks) {
    if (b.weight > 0.0 && !tells(b)) b.weight = 0.0;
    sum += b.weight;
  }
  if (!(sum > 0.0)) return;
  for (PriorBlock& b : blocks) b.weight /= sum;
}

void ScaleChart::start(int cols) {
  lambda_ = 0.0;
  first_told_ = cols;
  bent_.clear();
  d_.resize(cols);
  if (!keeps_scale_) return;
  l_.setZero(cols);
  q_.setZero(cols);
}

void ScaleChart::tell(const PriorBlock& block, const SmallVector& x) {
  if (block.weight == 0.0) return;
  first_told_ = std::min(first_told_, block.offset);
  double slope = 0.0;
  if (block.variable->orbit.kind == ScaleOrbit::Kind::kRates) {
    const Eigen::Vector3d v0 = block.x0.head<3>();
    const double square = v0.squaredNorm();
    lambda_ += block.weight * log_ratio(v0.dot(x.head<3>()) / square, slope);
    l_.segment<3>(block.offset) = block.weight * slope / square * v0;
    return;
  }
  const PointFunctions& point = *block.variable->orbit.point;
  const double rho0 = inverse_depth(block);
  lambda_ -= block.weight * log_ratio(point.inverse_depth(x) / rho0, slope);
  l_.segment<3>(block.offset) =
      -block.weight * slope / rho0 * point.inverse_depth_jacobian(x).transpose();
}

void ScaleChart::bend(const PriorBlock& block, const SmallVector& x) {
  const Variable& v = *block.variable;
  auto d = d_.segment(block.offset, v.dim());
  if (v.is_orientation || !keeps_scale_ || v.orbit.kind == ScaleOrbit::Kind::kNone) {
    d = minus(v.is_orientation, x, block.x0);
    if (v.is_orientation && turns_) {
      bent_.push_back({block.offset, 3, true, 1.0, transport(x, block.x0)});
    }
    return;
  }
  const SmallVector back = v.orbit.at(x, -lambda_), n0 = v.orbit.direction(block.x0);
  d = n0 * lambda_ + back - block.x0;
  q_.segment(block.offset, v.dim()) = n0 - v.orbit.direction(back);
  Bent bent;
  bent.offset = block.offset;
  bent.dim = v.orbit.kind == ScaleOrbit::Kind::kRates ? 3 : v.dim();
  bent.is_matrix = v.orbit.kind == ScaleOrbit::Kind::kPoint;
  if (bent.is_matrix) {
    bent.M = v.orbit.jacobian(x, -lambda_);
  } else {
    bent.factor = std::exp(-v.orbit.exponent() * lambda_);
  }
  bent_.push_back(bent);
}

void ScaleChart::erase(int offset, int dim) {
  const auto erase_from = [&](Eigen::VectorXd& v) {
    const Eigen::Index after = v.size() - offset - dim;
    if (after < 0) return;
    v.segment(offset, after) = v.tail(after).eval();
    v.conservativeResize(offset + after);
  };
  for (Eigen::VectorXd* v : {&d_, &l_, &q_}) erase_from(*v);
  std::erase_if(bent_, [&](const Bent& b) { return b.offset == offset; });
  for (Bent& b : bent_) {
    if (b.offset > offset) b.offset -= dim;
  }
  if (first_told_ > offset) first_told_ -= dim;
}

void ScaleChart::apply(Eigen::Ref<Eigen::MatrixXd> A) const {
  if (keeps_scale_) of_q_.noalias() = A * q_;
  for (const Bent& b : bent_) {
    if (b.is_matrix) {
      turn(A.middleCols<3>(b.offset), b.M);
    } else {
      A.middleCols(b.offset, b.dim) *= b.factor;
    }
  }
  if (keeps_scale_) A.noalias() += of_q_ * l_.transpose();
}

void ScaleChart::apply_transposed(Eigen::Ref<Eigen::VectorXd> g) const {
  const double of_q = keeps_scale_ ? q_.dot(g) : 0.0;
  for (const Bent& b : bent_) {
    if (b.is_matrix) {
      g.segment<3>(b.offset) = (b.M.transpose() * g.segment<3>(b.offset)).eval();
    } else {
      g.segment(b.offset, b.dim) *= b.factor;
    }
  }
  if (keeps_scale_) g += of_q * l_;
}

void ScaleChart::bend_gram(Eigen::Ref<Eigen::MatrixXd> G) const {
  double square = 0.0;
  if (keeps_scale_) {
    of_q_.noalias() = G * q_;
    square = q_.dot(of_q_);
  }
  for (const Bent& b : bent_) {
    if (b.is_matrix) {
      turn(G.middleCols<3>(b.offset), b.M);
      turn(G.middleRows<3>(b.offset).transpose(), b.M);
      if (keeps_scale_)
        of_q_.segment<3>(b.offset) = (b.M.transpose() * of_q_.segment<3>(b.offset)).eval();
    } else {
      G.middleCols(b.offset, b.dim) *= b.factor;
      G.middleRows(b.offset, b.dim) *= b.factor;
      of_q_.segment(b.offset, b.dim) *= b.factor;
    }
  }
  if (!keeps_scale_) return;
  G.noalias() += of_q_ * l_.transpose();
  of_q_ += square * l_;
  G.noalias() += l_ * of_q_.transpose();
}

}  // namespace slammot
