#include "smoothers/solver/landmark_block.h"

#include "estimation/estimator.h"
#include "models/lapack.h"

namespace slammot {

namespace {

// H's lower triangle gets M at (row, column) of the core.
template <typename Derived>
void add_block(Eigen::Ref<Eigen::MatrixXd> H, int row, int column,
               const Eigen::MatrixBase<Derived>& M) {
  if (row >= column) {
    H.block<Derived::RowsAtCompileTime, Derived::ColsAtCompileTime>(row, column, M.rows(),
                                                                    M.cols()) += M;
  } else {
    H.block<Derived::ColsAtCompileTime, Derived::RowsAtCompileTime>(column, row, M.cols(),
                                                                    M.rows()) += M.transpose();
  }
}

// W = Q R in place of W, by Gram and Schmidt, twice: the thin Q, which Eigen's QR has only by an
// allocation. False where a column depends on those before it.
bool orthonormalise(Eigen::Ref<Eigen::MatrixXd> W, LandmarkMatrix& R) {
  constexpr double kDependent = 1e-13;  // of its length is left: rounding
  R.setZero(W.cols(), W.cols());
  for (Eigen::Index j = 0; j < W.cols(); ++j) {
    const double length = W.col(j).norm();
    for (int again = 0; again < 2; ++again) {
      for (Eigen::Index i = 0; i < j; ++i) {
        const double along = W.col(i).dot(W.col(j));
        W.col(j) -= along * W.col(i);
        R(i, j) += along;
      }
    }
    R(j, j) = W.col(j).norm();
    if (!(R(j, j) > kDependent * length)) return false;
    W.col(j) /= R(j, j);
  }
  return true;
}

}  // namespace

void LandmarkBlock::eliminate(const Graph& graph, const GraphLandmark& l, double damping) {
  lay_out(graph, l);
  damp_noises(l, damping);
  fill(graph, l);
  if (independent_) {
    e_ = q_;
    return;
  }
  const bool has_noises = steps_ > 0 && rows_ > 0, has_states = first_private_ < states_;
  if (has_noises && !cholesky_in_place(*P_)) {
    throw Diverged("the noise of a landmark in the window is not finite");
  }
  if (has_states) eliminate_states(damping);
  if (rows_ == 0) return;
  if (has_noises) invert_cholesky_in_place(*P_);
  e_.noalias() = *P_ * q_;
  if (!has_states) return;
  e_ -= (*B_).lazyProduct(b_);
  (*P_).noalias() -= *B_ * (*B_).transpose();
}

// While P_ still is the factor L of M, or the identity.
void LandmarkBlock::eliminate_states(double damping) {
  const Eigen::Index dim = states_ - first_private_;
  const Eigen::Index damped = damping > 0.0 ? dim : 0;
  W_.resize(rows_ + damped, dim);
  auto W = *W_;
  W.setZero();
  r_.setZero(W.rows());
  const auto Y = (*X_).rightCols(dim);
  W.topRows(rows_) = Y;
  r_.head(rows_) = q_;
  if (steps_ > 0 && rows_ > 0) {
    solve_lower_in_place(*P_, W.topRows(rows_));
    solve_lower_in_place(*P_, r_.head(rows_));
  }
  if (damped > 0) {
    const LandmarkVector squares = Y.colwise().squaredNorm().transpose();
    W.bottomRows(dim) = (damping * squares).cwiseSqrt().asDiagonal();
  }
  LandmarkMatrix R;
  if (!orthonormalise(W, R)) {
    throw Diverged("the states of a landmark in the window are not determined");
  }
  const auto inverse = R.triangularView<Eigen::Upper>();
  b_ = W.transpose().lazyProduct(r_);
  u_ = inverse.solve(b_);
  const LandmarkMatrix root = inverse.solve(LandmarkMatrix::Identity(dim, dim));
  V_ = root.lazyProduct(root.transpose());
  B_.resize(rows_, dim);
  ZV_.resize(rows_, dim);
  *B_ = W.topRows(rows_);
  if (steps_ > 0) (*P_).triangularView<Eigen::Lower>().transpose().solveInPlace(*B_);
  (*ZV_).noalias() = *B_ * root.transpose();
}

void LandmarkBlock::add_to(Eigen::Ref<Eigen::MatrixXd> H, Eigen::Ref<Eigen::VectorXd> g) const {
  if (rows_ == 0) return;
  const auto A = *A_;
  const auto S = *S_;
  const auto P = *P_;
  PS_.resize(rows_, shared_cols_);
  auto PS = *PS_;
  if (independent_) {
    PS = S;
  } else {
    PS.noalias() = P * S;
  }
  for (const Shared& a : shared_) {
    const auto S_t = S.middleCols(a.column, a.dim).transpose();
    g.segment(a.core, a.dim) += S_t.lazyProduct(e_);
    for (const Shared& b : shared_) {
      if (b.core > a.core) continue;
      H.block(a.core, b.core, a.dim, b.dim) += S_t.lazyProduct(PS.middleCols(b.column, b.dim));
    }
  }
  for (int i = 0; i < pixels_; ++i) {
    const int pose = poses_[static_cast<std::size_t>(i)], row = 2 * i;
    const Eigen::Matrix<double, 6, 2> A_t = A.block<2, 6>(row, 0).transpose();
    g.segment<6>(pose) += A_t * e_.segment<2>(row);
    for (const Shared& s : shared_) {
      if (s.dim == 3) {
        const Eigen::Matrix<double, 2, 3> PS_i = PS.block<2, 3>(row, s.column);
        add_block(H, pose, s.core, A_t * PS_i);
      } else {
        const Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxMotion> PS_i =
            PS.block(row, s.column, 2, s.dim);
        const Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxMotion> product =
            A_t.lazyProduct(PS_i);
        add_block(H, pose, s.core, product);
      }
    }
    if (independent_) {
      H.block<6, 6>(pose, pose) += A_t * A_t.transpose();
      continue;
    }
    for (int j = 0; j <= i; ++j) {
      const int other = poses_[static_cast<std::size_t>(j)];
      const Eigen::Matrix<double, 6, 2> A_tP = A_t * P.block<2, 2>(row, 2 * j);
      const Matrix6d product = A_tP * A.block<2, 6>(2 * j, 0);
      add_block(H, pose, other, product);
      // Of two cameras of a rig both orders are of this block.
      if (j < i && other == pose) H.block<6, 6>(pose, pose) += product.transpose();
    }
  }
}

void LandmarkBlock::add_squares(Eigen::Ref<Eigen::VectorXd> squares) const {
  for (int i = 0; i < pixels_; ++i) {
    squares.segment<6>(poses_[static_cast<std::size_t>(i)]) +=
        (*A_).middleRows<2>(2 * i).colwise().squaredNorm().transpose();
  }
  for (const Shared& s : shared_) {
    squares.segment(s.core, s.dim) +=
        (*S_).middleCols(s.column, s.dim).colwise().squaredNorm().transpose();
  }
}

void LandmarkBlock::weigh(const Eigen::Ref<const Eigen::MatrixXd>& A, Eigen::Ref<Eigen::MatrixXd> C,
                          MotionMatrix& own) const {
  const Eigen::Index pixels = A.rows();
  Eigen::MatrixXd PA = Eigen::MatrixXd::Zero(rows_, A.cols());  // birth's rows stand last
  if (independent_) {
    PA.topRows(pixels) = A;
  } else {
    PA.noalias() = (*P_).leftCols(pixels) * A;
  }
  own = A.transpose() * PA.topRows(pixels);
  C.setZero();
  for (int i = 0; i < pixels_; ++i) {
    C.middleRows<6>(poses_[static_cast<std::size_t>(i)]).noalias() +=
        (*A_).middleRows<2>(2 * i).transpose() * PA.middleRows<2>(2 * i);
  }
  for (const Shared& s : shared_) {
    C.middleRows(s.core, s.dim).noalias() += (*S_).middleCols(s.column, s.dim).transpose() * PA;
  }
}

void LandmarkBlock::step(const Eigen::VectorXd& core, Graph& graph, GraphLandmark& l) const {
  if (independent_) return;
  change_.resize(rows_);
  for (int i = 0; i < pixels_; ++i) {
    change_.segment<2>(2 * i) =
        (*A_).block<2, 6>(2 * i, 0) * core.segment<6>(poses_[static_cast<std::size_t>(i)]);
  }
  change_.tail(rows_ - 2 * pixels_).setZero();
  for (const Shared& s : shared_) {
    if (rows_ == 0) break;
    change_ += (*S_).middleCols(s.column, s.dim).lazyProduct(core.segment(s.core, s.dim));
  }
  if (first_private_ < states_) {
    const LandmarkVector x = -u_ - (*ZV_).transpose().lazyProduct(change_);
    if (first_private_ == 0) graph.variables[l.y].step = x.head<3>();
    if (l.is_free()) graph.variables[l.w].step = x.tail(states_ - 3);
  }
  if (steps_ == 0) return;
  Eigen::VectorXd& lambda = weighted_;
  lambda = e_;
  if (rows_ > 0) lambda.noalias() += *P_ * change_;
  LandmarkVector adjoint = LandmarkVector::Zero(states_);
  int row = 2 * pixels_;
  for (int depth = steps_; depth > 0; --depth) {
    ChainStep& step = l.chain[static_cast<std::size_t>(depth - 1)];
    while (row > 0 && l.pixels[static_cast<std::size_t>(row / 2 - 1)].depth == depth) {
      row -= 2;
      adjoint.head<3>() +=
          l.pixels[static_cast<std::size_t>(row / 2)].at.J_y.transpose() * lambda.segment<2>(row);
    }
    step.step = -step.noise - step.G.transpose().lazyProduct(adjoint);
    if (!D_.empty()) step.step.array() /= D_[static_cast<std::size_t>(depth - 1)].array();
    adjoint = step.F.transpose().lazyProduct(adjoint).eval();
  }
}

void LandmarkBlock::newest(Eigen::Ref<Eigen::MatrixXd> E, LandmarkMatrix& covariance) const {
  for (const Shared& s : shared_) {
    if (s.is_state) E.middleRows(s.core, s.dim) += Phi_.middleCols(s.state, s.dim).transpose();
  }
  covariance = C_;
  if (independent_) return;
  const int dim = states_ - first_private_;
  if (rows_ == 0) return;
  gain_.resize(states_, rows_);
  auto gain = *gain_;
  gain.noalias() = *T_ * *P_;
  covariance -= gain.lazyProduct((*T_).transpose());
  if (dim > 0) {
    const auto Phi = Phi_.rightCols(dim);
    const LandmarkMatrix TZ = (*T_).lazyProduct(*ZV_);
    const LandmarkMatrix cross = TZ.lazyProduct(Phi.transpose()), PhiV = Phi.lazyProduct(V_);
    covariance += PhiV.lazyProduct(Phi.transpose()) - cross - cross.transpose();
    gain += Phi.lazyProduct((*ZV_).transpose());
  }
  for (int i = 0; i < pixels_; ++i) {
    E.middleRows<6>(poses_[static_cast<std::size_t>(i)]) -=
        (*A_).block<2, 6>(2 * i, 0).transpose().lazyProduct(gain.middleCols<2>(2 * i).transpose());
  }
  for (const Shared& s : shared_) {
    E.middleRows(s.core, s.dim).noalias() -=
        (*S_).middleCols(s.column, s.dim).transpose() * gain.transpose();
  }
}

}  // namespace slammot
