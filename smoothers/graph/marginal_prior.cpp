#include "smoothers/graph/marginal_prior.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace slammot {

const MarginalPrior::Block* MarginalPrior::find(VariableId id) const {
  const auto found = std::find_if(blocks_.begin(), blocks_.end(),
                                  [&](const Block& b) { return b.variable->id == id; });
  return found == blocks_.end() ? nullptr : &*found;
}

const ScaleChart& MarginalPrior::chart(Field b) const {
  chart_.bend(blocks_, cols_, [&](std::size_t i) { return blocks_[i].variable->*b; });
  return chart_;
}

const ScaleChart& MarginalPrior::chart_at_origin() const {
  chart_.bend(blocks_, cols_, [&](std::size_t i) { return blocks_[i].x0; });
  return chart_;
}

const Eigen::VectorXd& MarginalPrior::difference(Field b) const { return chart(b).difference(); }

const Eigen::VectorXd& MarginalPrior::residual(Field b) const {
  residual_ = r_;
  if (cols_ > 0) residual_.noalias() += *R_ * difference(b);
  for_own_rows([&](Eigen::Index first, int count) { residual_.segment(first, count).setZero(); });
  return residual_;
}

Eigen::Index MarginalPrior::row_of(int column) const {
  return std::ranges::lower_bound(starts_, column) - starts_.begin();
}

template <typename Function>
void MarginalPrior::for_own_rows(Function&& function) const {
  for (const Block& block : blocks_) {
    if (block.variable->is_considered) function(row_of(block.offset), block.dim());
  }
}

MarginalPrior::ConsideredRows MarginalPrior::own_rows(VariableId y, VariableId w) const {
  ConsideredRows rows;
  const Block* of_y = find(y);
  if (!of_y) return rows;
  rows.first = row_of(of_y->offset);
  rows.y = of_y->offset;
  rows.count = of_y->dim();
  if (const Block* of_w = w >= 0 ? find(w) : nullptr) {
    rows.w = of_w->offset;
    rows.count += of_w->dim();
  }
  return rows;
}

double MarginalPrior::own_square(const ConsideredRows& rows, Field b) const {
  if (rows.count == 0) return 0.0;
  SmallVector own = r_.segment(rows.first, rows.count);
  own.noalias() += (*R_).middleRows(rows.first, rows.count) * difference(b);
  return own.squaredNorm();
}

void MarginalPrior::fill_own(const ConsideredRows& rows, Eigen::Ref<Eigen::VectorXd> residual,
                             Eigen::MatrixXd& jacobian) const {
  jacobian = (*R_).middleRows(rows.first, rows.count);
  residual = r_.segment(rows.first, rows.count);
  residual.noalias() += jacobian * difference();
  chart_.apply(jacobian);
}

double MarginalPrior::square(Field b) const { return cols_ > 0 ? residual(b).squaredNorm() : 0.0; }

Eigen::MatrixXd MarginalPrior::jacobian() const {
  Eigen::MatrixXd J = *R_;
  chart().apply(J);
  return J;
}

const Eigen::VectorXd& MarginalPrior::gradient() const {
  gradient_.resize(cols_);
  if (cols_ == 0) return gradient_;
  gradient_.noalias() = (*R_).transpose() * residual();
  chart_.apply_transposed(gradient_);
  return gradient_;
}

// In the chart D n(b) = n(b0), if anything tells the scale; else n is that of the estimate.
Eigen::Vector2d MarginalPrior::along_scale() const {
  if (cols_ == 0) return Eigen::Vector2d::Zero();
  const Eigen::VectorXd& r = residual();
  along_.setZero(cols_);
  for (const Block& b : blocks_) {
    const Variable& v = *b.variable;
    if (!v.is_considered && !v.is_orientation) {
      along_.segment(b.offset, b.dim()) = v.orbit.direction(chart_.keeps_scale() ? b.x0 : v.value);
    }
  }
  of_scale_.noalias() = *R_ * along_;
  return {of_scale_.squaredNorm(), of_scale_.dot(r)};
}

// By panels of columns; rows below the last that is not zero (R is a triangle) are left out.
void MarginalPrior::compute_gram() const {
  if (has_gram_) return;
  constexpr Eigen::Index kPanel = 48;
  const Eigen::Index n = cols_;
  of_core_.resize(r_.size(), n);
  auto R = *of_core_;
  R = *R_;
  for_own_rows([&](Eigen::Index first, int count) { R.middleRows(first, count).setZero(); });
  gram_.resize(n, n);
  auto gram = *gram_;
  for (Eigen::Index c = 0; c < n; c += kPanel) {
    const Eigen::Index width = std::min(kPanel, n - c);
    Eigen::Index rows = R.rows();
    while (rows > 0 && (R.row(rows - 1).segment(c, width).array() == 0.0).all()) --rows;
    gram.block(c, c, n - c, width).noalias() =
        R.topRightCorner(rows, n - c).transpose() * R.block(0, c, rows, width);
  }
  has_gram_ = true;
}

// (R D)'(R D) is D'(R'R) D, in n^2: D fills the triangle of R where it tells the scale, and the
// product of a full R takes six times that of a triangle.
void MarginalPrior::bend_gram() {
  auto gram = *gram_;
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
  chart_.bend_gram(gram);
}

void MarginalPrior::find_runs() const {
  runs_.clear();
  for (const Block& block : blocks_) {
    const int core = block.variable->core, dim = block.dim();
    if (block.variable->is_constrained || block.variable->is_considered) continue;
    if (!runs_.empty() && runs_.back().core + runs_.back().dim == core &&
        runs_.back().offset + runs_.back().dim == block.offset) {
      runs_.back().dim += dim;
    } else {
      runs_.push_back({block.offset, core, dim});
    }
  }
}

void MarginalPrior::add_to(Eigen::Ref<Eigen::MatrixXd> H, Eigen::Ref<Eigen::VectorXd> g) const {
  runs_.clear();
  if (cols_ == 0) return;
  compute_gram();
  find_runs();
  gradient();
  linear_ = chart_;
  bent_.resize(cols_, cols_);
  auto bent = *bent_;
  bent = (*gram_).selfadjointView<Eigen::Lower>();
  linear_.bend_gram(bent);
  for (std::size_t j = 0; j < runs_.size(); ++j) {
    const Run& b = runs_[j];
    g.segment(b.core, b.dim) += gradient_.segment(b.offset, b.dim);
    for (std::size_t i = j; i < runs_.size(); ++i) {
      const Run& a = runs_[i];
      const auto block = bent.block(a.offset, b.offset, a.dim, b.dim);
      if (a.core >= b.core) {
        H.block(a.core, b.core, a.dim, b.dim) += block;
      } else {
        H.block(b.core, a.core, b.dim, a.dim) += block.transpose();
      }
    }
  }
}

void MarginalPrior::add_constrained(VariableId id, Eigen::Ref<Eigen::MatrixXd> information,
                                    Eigen::Ref<Eigen::MatrixXd> E) const {
  const Block* block = find(id);
  if (!block) return;
  const auto bent = *std::as_const(bent_);
  const int offset = block->offset, dim = block->dim(), after = cols_ - offset - dim;
  Eigen::MatrixXd K(dim, cols_);
  K.leftCols(offset) = bent.block(offset, 0, dim, offset);
  K.middleCols(offset, dim) =
      bent.block(offset, offset, dim, dim).selfadjointView<Eigen::Lower>().toDenseMatrix();
  K.rightCols(after) = bent.block(offset + dim, offset, after, dim).transpose();
  information += K.middleCols(offset, dim);
  add_transposed(K, E);
}

void MarginalPrior::add_cross(VariableId a, VariableId b,
                              Eigen::Ref<Eigen::MatrixXd> information) const {
  const Block *of_a = find(a), *of_b = find(b);
  if (!of_a || !of_b) return;
  const auto bent = *std::as_const(bent_);
  if (of_a->offset > of_b->offset) {
    information += bent.block(of_a->offset, of_b->offset, of_a->dim(), of_b->dim());
  } else {
    information += bent.block(of_b->offset, of_a->offset, of_b->dim(), of_a->dim()).transpose();
  }
}

void MarginalPrior::add_transposed(const Eigen::MatrixXd& K, Eigen::Ref<Eigen::MatrixXd> E) const {
  for (const Run& run : runs_) {
    E.middleRows(run.core, run.dim) += K.middleCols(run.offset, run.dim).transpose();
  }
}

void MarginalPrior::set(const std::vector<Variable*>& variables,
                        const Eigen::Ref<const Eigen::MatrixXd>& R,
                        const Eigen::Ref<const Eigen::VectorXd>& r) {
  blocks_.clear();
  R_.resize(R.rows(), R.cols());
  *R_ = R;
  r_ = r;
  cols_ = 0;
  has_gram_ = false;
  for (Variable* v : variables) {
    if (fixed_points_) v->keep_point();
    v->is_private = false;
    blocks_.push_back({v, cols_, v->value});
    cols_ += v->dim();
  }
  starts_.resize(static_cast<std::size_t>(R.rows()));
  std::iota(starts_.begin(), starts_.end(), 0);
  if (!chart_.keeps_scale() || cols_ == 0) return;
  compute_gram();
  const auto gram = *std::as_const(gram_);
  chart_.weigh(blocks_, [&](const Block& b) -> BlockMatrix {
    return gram.block(b.offset, b.offset, b.dim(), b.dim()).selfadjointView<Eigen::Lower>();
  });
}

void MarginalPrior::relinearise() {
  if (cols_ == 0) return;
  r_.noalias() += *R_ * difference();
  chart_.apply(*R_);
  if (has_gram_) bend_gram();
  for (Block& block : blocks_) {
    block.x0 = block.variable->value;
    for (int& start : starts_) {  // D mixes a block's columns
      if (start > block.offset && start < block.offset + block.dim()) start = block.offset;
    }
  }
  for (int& start : starts_) start = std::min(start, chart_.first_told());
  ScaleChart::normalise(blocks_);
  if (chart_.keeps_scale()) linear_ = chart();
}

void MarginalPrior::condition_on_zero(VariableId id) {
  const auto k = blocks_.begin() + (find(id) - blocks_.data());
  const int offset = k->offset, dim = k->dim(), kept = cols_ - dim, after = kept - offset;
  const Eigen::MatrixXd old = *R_;
  r_.noalias() -= old.middleCols(offset, dim) * k->x0;
  R_.resize(old.rows(), kept);
  (*R_).leftCols(offset) = old.leftCols(offset);
  (*R_).rightCols(after) = old.rightCols(after);
  has_gram_ = false;
  cols_ = kept;
  for (int& start : starts_) {
    if (start > offset) start = std::max(offset, start - dim);
  }
  erase_linear(offset, dim);
  for (auto later = blocks_.erase(k); later != blocks_.end(); ++later) later->offset -= dim;
}

// A constrained variable has no run.
void MarginalPrior::erase_linear(int offset, int dim) {
  for (Run& run : runs_) {
    if (run.offset > offset) run.offset -= dim;
  }
  linear_.erase(offset, dim);
  if (bent_.cols() != cols_ + dim) return;
  const int after = cols_ - offset;
  const Eigen::MatrixXd old = *bent_;
  bent_.resize(cols_, cols_);
  auto bent = *bent_;
  bent.topLeftCorner(offset, offset) = old.topLeftCorner(offset, offset);
  bent.bottomLeftCorner(after, offset) = old.bottomLeftCorner(after, offset);
  bent.bottomRightCorner(after, after) = old.bottomRightCorner(after, after);
}

void MarginalPrior::join(const std::vector<Variable*>& variables, const Eigen::VectorXd& mean,
                         const Eigen::MatrixXd& K, const Eigen::MatrixXd& U) {
  const Eigen::Index n = mean.size(), m = cols_, rows = r_.size();
  const Eigen::MatrixXd old = *R_;
  R_.resize(n + rows, n + m);
  auto R = *R_;
  R.topLeftCorner(n, n) = U;
  if (m > 0) {
    R.topRightCorner(n, m).noalias() = -U * K;
    R.bottomLeftCorner(rows, n).setZero();
    R.bottomRightCorner(rows, m) = old;
  }
  has_gram_ = false;
  r_ = (Eigen::VectorXd(n + rows) << Eigen::VectorXd::Zero(n), r_).finished();
  for (int& start : starts_) start += static_cast<int>(n);
  starts_.insert(starts_.begin(), static_cast<std::size_t>(n), 0);
  std::iota(starts_.begin(), starts_.begin() + n, 0);
  std::vector<Block> blocks;
  int offset = 0;
  for (Variable* v : variables) {
    blocks.push_back({v, offset, mean.segment(offset, v->dim())});
    v->is_private = false;
    offset += v->dim();
  }
  for (Block& block : blocks_) block.offset += offset;
  blocks_.insert(blocks_.begin(), blocks.begin(), blocks.end());
  cols_ = static_cast<int>(n + m);
}

}  // namespace slammot
