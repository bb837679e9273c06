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

void Marginals::constrained_motions(std::span<const int> tracks, RememberedMotions& result) {
  const LandmarkFunctions& functions = *graph_.models().landmark;
  const Eigen::Index n = functions.motion;
  tracks_.clear();
  for (const int track : tracks) {
    if (graph_[landmarks_.at(track).id].constrained) tracks_.push_back(track);
  }
  result.reset(std::ssize(tracks_), functions.motion);
  if (tracks_.empty()) return;
  const Eigen::VectorXd& prior_gradient = graph_.prior().active.gradient();
  motion_columns_.resize(equations_.core_dim(), n * std::ssize(tracks_));
  MotionMatrix information;
  MotionVector vector;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const WindowLandmark& landmark = landmarks_.at(tracks_[i]);
    auto of_core = (*motion_columns_).middleCols(n * static_cast<Eigen::Index>(i), n);
    add_information(landmark.id, prior_gradient, of_core, information, vector);
    result.add(tracks_[i], at_rest(landmark).head<3>());
    result.information(i, i) = information;
    result.vector(i) = vector;
    for (std::size_t k = 0; k < i; ++k) add_shared(i, k, result);
  }
  equations_.whiten(*motion_columns_);
  result.know_given(*motion_columns_);
}

// What the prior says of two of them together.
void Marginals::add_shared(std::size_t i, std::size_t k, RememberedMotions& result) const {
  const auto w = [&](std::size_t of) {
    return graph_[landmarks_.at(tracks_[of]).id].constrained->w;
  };
  Eigen::MatrixXd shared = result.information(i, k);
  graph_.prior().active.add_cross(w(i), w(k), shared);
  result.information(i, k) = shared;
  result.information(k, i) = shared.transpose();
}

// As if the core were known; and D.
void Marginals::add_information(LandmarkId id, const Eigen::VectorXd& prior_gradient,
                                Eigen::Ref<Eigen::MatrixXd> of_core, MotionMatrix& information,
                                MotionVector& vector) {
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
  const MotionPrior& of_w = l.constrained->prior;
  if (of_w.rows() > 0) own.diagonal() += of_w.J_w.cwiseAbs2();
  information = own;
  vector = -gradient;
}

}  // namespace slammot
