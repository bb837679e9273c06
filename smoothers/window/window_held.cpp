// A label that can be undone. The motion w of a static landmark is a variable that is held at zero.
// What leaves the window goes into the prior with its columns for w: had the landmark moved with w
// since the time of y, it had been seen at y + F_yw(t) w, F_yw of its model's prediction at rest.
// Of the pixels in the window A is the Jacobian with respect to w, r their residuals, P and B = P J
// those of given_others.h; C are the columns of w in the prior, R and r_p the rest of it. Then
//
//   J_w = A' P A + C'C - D' Sigma D + diag(sigmas)^-2,   D = B'A + R'C,
//   w = -J_w^-1 (A' r + C' r_p),
//
// that is, the marginal of w were it free, by one Gauss-Newton step. The filter keeps the same
// (held_motion.cpp). The term with sigmas is in the prior once a pixel has left.
#include <Eigen/Cholesky>

#include "smoothers/window/window_belief.h"

namespace slammot {

// Of what is static for long enough, or about to be deactivated.
void Window::forget_motions() {
  const bool is_full = static_cast<int>(cameras_.frames().size()) > options_.frames;
  for (const auto& [track, landmark] : landmarks_) {
    if (!graph_[landmark.id].held) continue;
    const bool is_old = cameras_.newest().number - *landmark.rests_since > memory_;
    const bool is_unseen = is_full && landmark.last_used <= cameras_.oldest().index;
    if (is_old || is_unseen) graph_.forget_held(landmark.id);
  }
}

void Window::motion_rows(const WindowLandmark& landmark, GrowingMatrix& A) const {
  const GraphLandmark& l = graph_[landmark.id];
  const Eigen::Vector3d y = graph_.variables[l.y].value;
  A.resize(2 * std::ssize(l.pixels), functions_.motion);
  for (Eigen::Index i = 0; i < std::ssize(l.pixels); ++i) {
    const GraphPixel& pixel = l.pixels[static_cast<std::size_t>(i)];
    const double dt = cameras_.find(pixel.position)->timestamp - landmark.rest_time;
    (*A).middleRows<2>(2 * i).noalias() =
        pixel.at.J_y * moved_from_rest(functions_, y, std::max(0.0, dt));
  }
}

void Window::held_motions(std::span<const int> tracks, std::vector<MotionBelief>& result) {
  result.clear();
  if (memory_ == 0 || tracks.empty()) return;
  const NormalEquations& equations = optimiser_.equations();
  const MarginalPrior& prior = graph_.prior().active;
  const Eigen::VectorXd& prior_residual = prior.residual();
  const Eigen::Index n = functions_.motion;
  motion_columns_.resize(equations.core_dim(), n * std::ssize(tracks));
  for (const int track : tracks) {
    const WindowLandmark& landmark = landmarks_.at(track);
    const GraphLandmark& l = graph_[landmark.id];
    if (!l.held || l.pixels.size() < 2) continue;
    motion_rows(landmark, motion_rows_);
    MotionMatrix own;
    auto columns = (*motion_columns_).middleCols(n * std::ssize(result), n);
    equations.block(landmark.id).weigh(*motion_rows_, columns, own);
    MotionVector gradient = MotionVector::Zero(n);
    for (Eigen::Index i = 0; i < std::ssize(l.pixels); ++i) {
      gradient += (*motion_rows_).middleRows<2>(2 * i).transpose() *
                  l.pixels[static_cast<std::size_t>(i)].at.r;
    }
    prior.add_held(l.held->w, prior_residual, own, columns, gradient);
    if (l.held->sigmas.size() > 0) own.diagonal() += l.held->sigmas.cwiseAbs2().cwiseInverse();
    MotionBelief& motion = result.emplace_back();
    motion.track = track;
    motion.covariance = own;  // an information, so far
    motion.w = -gradient;
  }
  auto columns = (*motion_columns_).leftCols(n * std::ssize(result));
  if (!result.empty()) equations.whiten(columns);
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
    motion.density_scale = functions_.density_scale(x);
    result[determined++] = motion;
  }
  result.resize(determined);
}

// It is free with its pixels of the window and all that the prior knows of it, and the window is
// solved once more. What was refused of it before its base is not of that point.
void Window::release(int track, const LandmarkPrior& /*prior*/) {
  WindowLandmark& landmark = landmarks_.at(track);
  const WindowFrame& base = base_of_release(landmark);
  if (histories_) histories_->rested_until(track, base.number, at_rest(landmark));
  landmark.is_free = true;
  landmark.rests_since.reset();
  graph_.release(landmark.id);
  move_to_base(landmark, base);
  move_since(landmark, base);
  std::erase_if(refused_, [&](const RefusedPixel& refused) {
    return refused.z.track == track && cameras_.find(refused.position)->number < base.number;
  });
  truth_.apply(landmark);
  graph_.prior().relinearise();
  optimiser_.take_step(graph_, cameras_.newest().camera);
  estimate_camera();
}

// Where its pixels in the window begin, but not before the time of y: it was at rest then.
const WindowFrame& Window::base_of_release(const WindowLandmark& landmark) const {
  auto frame = cameras_.find(graph_[landmark.id].pixels.front().position);
  while (frame->timestamp < landmark.rest_time) ++frame;
  return *frame;
}

// From the time of y, where it may have left the window, to this frame: a step without noise.
void Window::move_to_base(const WindowLandmark& landmark, const WindowFrame& base) {
  GraphLandmark& l = graph_[landmark.id];
  if (base.timestamp <= landmark.rest_time) return;
  ChainStep step;
  step.dt = base.timestamp - landmark.rest_time;
  step.G.setZero(functions_.dim(), functions_.dim());
  step.noise.setZero(functions_.dim());
  l.chain.push_back(step);
  for (GraphPixel& pixel : l.pixels) pixel.depth = 1;
  leaving_.clear();
  Departure& d = leaving_.departures.emplace_back();
  d.landmark = landmark.id;
  d.steps = 1;
  d.absorbs_prior_of_w = true;
  marginaliser_(graph_, leaving_);
}

// Its chain begins in this frame, and its pixels are measured along it.
void Window::move_since(WindowLandmark& landmark, const WindowFrame& base) {
  landmark.base = base.camera.position;
  double time = base.timestamp;
  for (const WindowFrame& frame : cameras_.frames()) {
    if (frame.number <= base.number) continue;
    extend(landmark, Label::kUnknown, frame.timestamp - time);
    time = frame.timestamp;
  }
  GraphLandmark& l = graph_[landmark.id];
  for (GraphPixel& pixel : l.pixels) {
    pixel.depth = std::max(0, cameras_.find(pixel.position)->number - base.number);
  }
  graph_.linearise(l);
}

}  // namespace slammot
