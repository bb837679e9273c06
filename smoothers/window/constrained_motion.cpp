// What the motion of a static landmark would be, were it not constrained to zero.
//
// w is a variable that stays at zero. Had the landmark moved with w since the time of y, it had
// been seen at y + F_yw(t) w, F_yw of its model's prediction at rest: every pixel has a Jacobian
// with respect to w, taken where its others are (GraphPixel::J_w), and what leaves the window goes
// into the prior with its columns for w. Of the pixels in the window A is that Jacobian, r their
// residuals, J their Jacobian with respect to the core, P their weight (landmark_block.h); C are
// the columns of w in the prior, R and r_p the rest of it. Then
//
//   J_w = A' P A + C'C - D' Sigma D + diag(sigmas)^-2,   D = J'P A + R'C,
//   w = -J_w^-1 (A' r + C' r_p),
//
// that is, the marginal of w were it free, by one Gauss-Newton step. The filter keeps the same. The
// term with sigmas is in the prior once a pixel has left.
#include <Eigen/Cholesky>

#include "smoothers/window/marginals.h"

namespace slammot {

void Marginals::constrained_motions(std::span<const int> tracks,
                                    std::vector<MotionBelief>& result) {
  result.clear();
  if (tracks.empty()) return;
  const LandmarkFunctions& functions = *graph_.models().landmark;
  const Eigen::VectorXd& prior_gradient = graph_.prior().active.gradient();
  const Eigen::Index n = functions.motion;
  motion_columns_.resize(equations_.core_dim(), n * std::ssize(tracks));
  for (const int track : tracks) {
    const LandmarkId id = landmarks_.at(track).id;
    if (!graph_[id].constrained) continue;
    const Eigen::Index first = n * std::ssize(result);
    MotionBelief& motion = result.emplace_back();
    motion.track = track;
    add_information(id, prior_gradient, (*motion_columns_).middleCols(first, n), motion);
  }
  auto columns = (*motion_columns_).leftCols(n * std::ssize(result));
  if (!result.empty()) equations_.whiten(columns);
  std::size_t determined = 0;
  for (Eigen::Index i = 0; i < std::ssize(result); ++i) {
    MotionBelief& motion = result[static_cast<std::size_t>(i)];
    const auto of_core = columns.middleCols(n * i, n);
    const Eigen::LLT<MotionMatrix> llt(motion.covariance - of_core.transpose() * of_core);
    if (llt.info() != Eigen::Success) continue;
    motion.covariance = llt.solve(MotionMatrix::Identity(n, n));
    motion.w = llt.solve(motion.w).eval();
    LandmarkVector x = at_rest(landmarks_.at(motion.track));
    x.tail(n) = motion.w;
    motion.density_scale = functions.density_scale(x);
    result[determined++] = motion;
  }
  result.resize(determined);
}

// As if the core were known, an information in `covariance` and a gradient in `w`; and D.
void Marginals::add_information(LandmarkId id, const Eigen::VectorXd& prior_gradient,
                                Eigen::Ref<Eigen::MatrixXd> of_core, MotionBelief& motion) {
  const GraphLandmark& l = graph_[id];
  const Eigen::Index n = graph_.models().landmark->motion;
  motion_rows_.resize(2 * std::ssize(l.pixels), n);
  MotionVector gradient = MotionVector::Zero(n);
  Eigen::Index row = 0;
  for (const GraphPixel& pixel : l.pixels) {
    (*motion_rows_).middleRows<2>(row) = pixel.J_w;
    gradient += pixel.J_w.transpose() * pixel.at.r;
    row += 2;
  }
  MotionMatrix own = MotionMatrix::Zero(n, n);
  if (l.pixels.empty()) {
    of_core.setZero();
  } else {
    equations_.block(id).weigh(*motion_rows_, of_core, own);
  }
  const MarginalPrior& prior = graph_.prior().active;
  prior.add_constrained(l.constrained->w, own, of_core);
  if (const PriorBlock* w = prior.find(l.constrained->w)) {
    gradient += prior_gradient.segment(w->offset, n);
  }
  const MotionVector& sigmas = l.constrained->sigmas;
  if (sigmas.size() > 0) own.diagonal() += sigmas.cwiseAbs2().cwiseInverse();
  motion.covariance = own;
  motion.w = -gradient;
}

}  // namespace slammot
