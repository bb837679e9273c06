#include "smoothers/solver/landmark_block.h"

#include "estimation/estimator.h"
#include "smoothers/linear/lapack.h"

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

}  // namespace

void LandmarkBlock::lay_out(const Graph& graph, const GraphLandmark& l) {
  pixels_ = static_cast<int>(l.pixels.size());
  own_ = l.is_considered ? graph.prior().active.own_rows(l.y, l.w) : MarginalPrior::OwnRows{};
  rows_ = 2 * pixels_ + l.birth.rows() + static_cast<int>(own_.count);
  steps_ = l.steps();
  states_ = l.is_free() ? graph.models().landmark->dim() : 3;
  share_core(graph, l);
  independent_ = steps_ == 0 && first_private_ == states_;
  poses_.clear();
  for (const GraphPixel& pixel : l.pixels) poses_.push_back(graph.variables[pixel.position].core);
  A_.resize(rows_, 6);
  X_.resize(rows_, states_);
  S_.resize(rows_, shared_cols_);
  T_.resize(states_, rows_);
  P_.resize(rows_, rows_);
  q_.resize(rows_);
  e_.resize(rows_);
}

void LandmarkBlock::share_core(const Graph& graph, const GraphLandmark& l) {
  const Variable& y = graph.variables[l.y];
  shared_.clear();
  shared_cols_ = 0;
  first_private_ = 0;
  const auto share = [&](const Variable& v, bool is_state, int state) {
    shared_.push_back({v.core, shared_cols_, v.dim(), is_state, state});
    shared_cols_ += v.dim();
  };
  share(graph.variables[l.anchor], false, 0);
  if (!y.is_private && !l.is_considered) {
    share(y, true, 0);
    first_private_ = 3;
    if (l.is_free() && !graph.variables[l.w].is_private) {
      share(graph.variables[l.w], true, 3);
      first_private_ = states_;
    }
  }
  scene_column_ = shared_cols_;
  if (l.birth.kind == BirthPrior::Kind::kSharedDepth) {
    share(graph.variables[l.birth.scene], false, 0);
  }
  own_column_ = shared_cols_;
  if (own_.count == 0) return;
  for (const MarginalPrior::Run& run : graph.prior().active.runs()) {
    shared_.push_back({run.core, shared_cols_, run.dim, false, 0});
    shared_cols_ += run.dim;
  }
}

// The chain moves on by one step: the covariances of its newest state with the rows so far follow.
void LandmarkBlock::advance(const ChainStep& step, std::size_t index, Eigen::Index rows) {
  LandmarkMatrix GD = step.G;
  LandmarkVector drift = step.noise;
  if (!D_.empty()) {
    GD *= D_[index].cwiseInverse().asDiagonal();
    drift.array() /= D_[index].array();
  }
  drift_ = (step.F.lazyProduct(drift_) + step.G.lazyProduct(drift)).eval();
  const LandmarkMatrix FC = step.F.lazyProduct(C_);
  C_ = FC.lazyProduct(step.F.transpose());
  C_ += GD.lazyProduct(step.G.transpose());
  Phi_ = step.F.lazyProduct(Phi_).eval();
  auto T = *T_;
  for (Eigen::Index row = 0; row < rows; row += 2) {
    auto two = T.middleCols<2>(row);
    two = step.F.lazyProduct(two).eval();
  }
}

// What the noises of the chain are damped by: D = 1 + damping (1 + squares of N's columns).
void LandmarkBlock::damp_noises(const GraphLandmark& l, double damping) {
  D_.assign(damping > 0.0 ? l.chain.size() : 0, {});
  if (D_.empty()) return;
  LandmarkMatrix information = LandmarkMatrix::Zero(states_, states_);
  auto pixel = l.pixels.rbegin();
  for (int depth = l.steps(); depth > 0; --depth) {
    const ChainStep& step = l.chain[static_cast<std::size_t>(depth - 1)];
    for (; pixel != l.pixels.rend() && pixel->depth == depth; ++pixel) {
      information.topLeftCorner<3, 3>() += pixel->at.J_y.transpose() * pixel->at.J_y;
    }
    const LandmarkMatrix IG = information.lazyProduct(step.G);
    const LandmarkMatrix squares = step.G.transpose().lazyProduct(IG);
    D_[static_cast<std::size_t>(depth - 1)] =
        ((1.0 + damping) + damping * squares.diagonal().array()).matrix();
    const LandmarkMatrix IF = information.lazyProduct(step.F);
    information = step.F.transpose().lazyProduct(IF);
  }
}

void LandmarkBlock::fill_row(const GraphPixel& pixel, Eigen::Index row) {
  const auto J_y = pixel.at.J_y;
  (*A_).block<2, 6>(row, 0) = pixel.at.J_pose;
  (*X_).middleRows<2>(row) = J_y.lazyProduct(Phi_.topRows<3>());
  (*S_).middleRows<2>(row).leftCols<3>() = pixel.at.J_anchor;
  q_.segment<2>(row) = pixel.at.r;
  if (pixel.depth == 0) {
    (*T_).middleCols<2>(row).setZero();
    return;
  }
  q_.segment<2>(row) -= J_y * drift_.head<3>();
  auto M = *P_;
  auto T = *T_;
  T.middleCols<2>(row) = C_.leftCols<3>().lazyProduct(J_y.transpose());
  for (Eigen::Index j = 0; j <= row; j += 2) {
    M.block<2, 2>(row, j) += J_y * T.block<3, 2>(0, j);
  }
}

void LandmarkBlock::fill_birth(const GraphLandmark& l) {
  const int rows = l.birth.rows();
  if (rows == 0) return;
  const int first = 2 * pixels_;
  (*A_).middleRows(first, rows).setZero();
  (*X_).middleRows(first, rows).setZero();
  (*X_).middleRows(first, rows).leftCols<3>() = l.birth.J_y.topRows(rows);
  (*S_).middleRows(first, rows).leftCols<3>() = l.birth.J_anchor.topRows(rows);
  if (l.birth.kind == BirthPrior::Kind::kSharedDepth) {
    (*S_).middleRows(first, rows).col(scene_column_) = l.birth.J_scene.topRows(rows);
  }
  (*T_).middleCols(first, rows).setZero();
  q_.segment(first, rows) = l.birth.r.head(rows);
}

void LandmarkBlock::fill_prior(const Graph& graph) {
  if (own_.count == 0) return;
  const MarginalPrior& prior = graph.prior().active;
  Eigen::MatrixXd rows;
  prior.fill_own(own_, q_.tail(own_.count), rows);
  auto X = (*X_).bottomRows(own_.count);
  (*A_).bottomRows(own_.count).setZero();
  X.setZero();
  X.leftCols<3>() = rows.middleCols<3>(own_.y);
  if (own_.w >= 0) X.rightCols(states_ - 3) = rows.middleCols(own_.w, states_ - 3);
  (*T_).rightCols(own_.count).setZero();
  Eigen::Index column = own_column_;
  for (const MarginalPrior::Run& run : prior.runs()) {
    (*S_).bottomRows(own_.count).middleCols(column, run.dim) = rows.middleCols(run.offset, run.dim);
    column += run.dim;
  }
}

void LandmarkBlock::fill(const Graph& graph, const GraphLandmark& l) {
  (*S_).setZero();
  if (!independent_) {
    (*P_).setIdentity();
  }
  Phi_.setIdentity(states_, states_);
  C_.setZero(states_, states_);
  drift_.setZero(states_);
  auto pixel = l.pixels.begin();
  Eigen::Index row = 0;
  for (int depth = 0; depth <= steps_; ++depth) {
    if (depth > 0)
      advance(l.chain[static_cast<std::size_t>(depth - 1)], static_cast<std::size_t>(depth - 1),
              row);
    for (; pixel != l.pixels.end() && pixel->depth == depth; ++pixel, row += 2) {
      fill_row(*pixel, row);
    }
  }
  fill_birth(l);
  fill_prior(graph);
  auto S = *S_;
  for (const Shared& s : shared_) {
    if (s.is_state) S.middleCols(s.column, s.dim) = (*X_).middleCols(s.state, s.dim);
  }
}

void LandmarkBlock::eliminate(const Graph& graph, const GraphLandmark& l, double damping) {
  lay_out(graph, l);
  damp_noises(l, damping);
  fill(graph, l);
  if (independent_) {
    e_ = q_;
    return;
  }
  if (steps_ > 0 && rows_ > 0) {
    if (!cholesky_in_place(*P_)) {
      throw Diverged("the noise of a landmark in the window is not finite");
    }
    invert_cholesky_in_place(*P_);
  }
  if (rows_ > 0) e_.noalias() = *P_ * q_;
  if (first_private_ < states_) eliminate_states(graph, l, damping);
}

void LandmarkBlock::eliminate_states(const Graph& graph, const GraphLandmark& l, double damping) {
  const int dim = states_ - first_private_;
  const auto Y = (*X_).rightCols(dim);
  Z_.resize(rows_, dim);
  ZV_.resize(rows_, dim);
  V_.setZero(dim, dim);
  u_.setZero(dim);
  LandmarkVector squares = LandmarkVector::Zero(dim);
  if (rows_ > 0) {
    (*Z_).noalias() = *P_ * Y;
    V_.noalias() += Y.transpose() * *Z_;
    u_ += (*Z_).transpose().lazyProduct(q_);
    squares = Y.colwise().squaredNorm().transpose();
  }
  if (l.w_sigmas.size() > 0) {  // then w is private
    const Eigen::Index motion = l.w_sigmas.size();
    const MotionVector information = l.w_sigmas.cwiseAbs2().cwiseInverse();
    V_.diagonal().tail(motion) += information;
    squares.tail(motion) += information;
    u_.tail(motion) += information.cwiseProduct(graph.variables[l.w].value);
  }
  V_.diagonal() += damping * squares;
  const Eigen::LLT<LandmarkMatrix> llt(V_);
  if (llt.info() != Eigen::Success) {
    throw Diverged("the states of a landmark in the window are not determined");
  }
  V_ = llt.solve(LandmarkMatrix::Identity(dim, dim));
  u_ = V_.lazyProduct(u_).eval();
  if (rows_ == 0) return;
  (*ZV_).noalias() = *Z_ * V_;
  e_ -= (*Z_).lazyProduct(u_);
  (*P_).noalias() -= *ZV_ * (*Z_).transpose();
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
      const Eigen::Matrix<double, 6, 2> A_tP = A_t * P.block<2, 2>(row, 2 * j);
      add_block(H, pose, poses_[static_cast<std::size_t>(j)], A_tP * A.block<2, 6>(2 * j, 0));
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
    LandmarkVector x = -u_;
    if (rows_ > 0) x -= (*ZV_).transpose().lazyProduct(change_);
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
  if (rows_ == 0) {
    if (dim == 0) return;  // V_ is not of this block then, or was never set
    const auto Phi = Phi_.rightCols(dim);
    covariance += Phi * V_ * Phi.transpose();
    return;
  }
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
